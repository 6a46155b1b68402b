#include "coordinator/watch/page_server.h"

#include <gtest/gtest.h>
#include <httplib.h>

#include <chrono>
#include <future>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>

namespace knap {
namespace page_server_test {

TEST(PageServerTest, ReadsAddresses) {
  const ListenAddress here = ParseListenAddress("127.0.0.1:8080");
  EXPECT_EQ(here.host, "127.0.0.1");
  EXPECT_EQ(here.port, 8080);
  const ListenAddress six = ParseListenAddress("[::1]:0");
  EXPECT_EQ(six.host, "::1");
  EXPECT_EQ(six.port, 0);
  for (const char* wrong : {"", "8080", "localhost", "localhost:", ":8080", "[]:80", "localhost:port", "localhost:-1",
                            "localhost:65536", "localhost:80x", "localhost:99999999999"}) {
    EXPECT_THROW(ParseListenAddress(wrong), std::invalid_argument) << wrong;
  }
}

TEST(PageServerTest, SaysWhatKeepsItFromServing) {
  const ServedPage content{[] { return std::string(); }, [](const std::string&) { return std::string(); }};
  const PageServer first({}, content);
  const ListenAddress taken =
      ParseListenAddress(first.url().substr(sizeof("http://") - 1, first.url().size() - sizeof("http://")));
  EXPECT_THROW(PageServer(taken, content), std::runtime_error);
  EXPECT_THROW(PageServer({"no.such.host.invalid", 0}, content), std::runtime_error);
}

// The last page of a run is its report: the server's end must not cut it off.
TEST(PageServerTest, EndsAfterTheAnswersThatHaveBegun) {
  const std::string report(1 << 20, 'x');
  std::promise<void> begun;
  ServedPage content;
  content.page = [&] {
    begun.set_value();
    // Time for an end that does not wait to come first.
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    return report;
  };
  content.news = [](const std::string&) { return std::string(); };
  auto server = std::make_unique<PageServer>(ListenAddress{}, content);
  auto answer = std::async(std::launch::async, [url = server->url()] {
    httplib::Client client(url.substr(0, url.size() - 1));
    const httplib::Result result = client.Get("/");
    return result ? result->body : "no answer";
  });
  begun.get_future().wait();
  server.reset();
  EXPECT_EQ(answer.get(), report);
}

}  // namespace page_server_test
}  // namespace knap

#include "coordinator/watch/page_server.h"

#include <fmt/format.h>
#include <httplib.h>
#include <sodium.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstring>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

#include "lcmtypes/wire/text.h"

namespace knap {
namespace {

constexpr int kThreads = 4;
constexpr int kForbidden = 403;
constexpr std::size_t kTokenBytes = 16;

bool IsLoopback(const std::string& host) { return host == "127.0.0.1" || host == "::1" || host == "localhost"; }

std::string MakeToken() {
  if (sodium_init() < 0) throw std::runtime_error("libsodium cannot be initialised");
  std::array<unsigned char, kTokenBytes> bytes{};
  randombytes_buf(bytes.data(), bytes.size());
  std::array<char, 2 * kTokenBytes + 1> text{};
  sodium_bin2hex(text.data(), text.size(), bytes.data(), bytes.size());
  return text.data();
}

// In constant time.
bool AreEqual(const std::string& a, const std::string& b) {
  return a.size() == b.size() && sodium_memcmp(a.data(), b.data(), a.size()) == 0;
}

// What others would call the address: all of a machine has its name.
std::string MakeHostText(const std::string& host) {
  if (host == "0.0.0.0" || host == "::") {
    std::array<char, 256> name{};
    if (gethostname(name.data(), name.size() - 1) == 0) return CleanText(name.data());
  }
  return host.find(':') == std::string::npos ? host : "[" + host + "]";
}

// As it is: the library would compress it at its leisure, which costs the run more than a loopback gains. The response
// keeps `answer` until it has been written.
void Send(std::string text, const char* type, std::shared_ptr<const void> answer, httplib::Response* response) {
  const auto body = std::make_shared<const std::string>(std::move(text));
  response->set_content_provider(
      body->size(), type,
      [body, answer = std::move(answer)](std::size_t offset, std::size_t length, httplib::DataSink& sink) {
        return sink.write(body->data() + offset, length);
      });
}

}  // namespace

ListenAddress ParseListenAddress(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  ListenAddress address;
  const char* const end = text.data() + text.size();
  const char* const port = colon == std::string::npos ? end : text.data() + colon + 1;
  const auto [last, error] = std::from_chars(port, end, address.port);
  if (colon == std::string::npos || port == end || last != end || error != std::errc() || address.port < 0 ||
      address.port > 65535) {
    throw std::invalid_argument(fmt::format("--listen {}: expected HOST:PORT, with a port from 0 to 65535", text));
  }
  address.host = text.substr(0, colon);
  if (address.host.starts_with('[') && address.host.ends_with(']')) {
    address.host = address.host.substr(1, address.host.size() - 2);
  }
  if (address.host.empty()) {
    throw std::invalid_argument(fmt::format("--listen {}: no host; 0.0.0.0 stands for all of this machine", text));
  }
  return address;
}

struct PageServer::Listener {
  // How many answers are under way. The library, when stopped, leaves out whatever of them it has not begun to write.
  class OpenAnswers {
   public:
    // Ends with the last copy of what it returns.
    std::shared_ptr<const void> Begin() {
      const std::scoped_lock lock(mutex_);
      ++count_;
      return {this, [](OpenAnswers* self) { self->End(); }};
    }

    void WaitUntilNone() {
      std::unique_lock lock(mutex_);
      ended_.wait(lock, [this] { return count_ == 0; });
    }

   private:
    void End() {
      const std::scoped_lock lock(mutex_);
      --count_;
      ended_.notify_all();
    }

    std::mutex mutex_;
    std::condition_variable ended_;
    int count_ = 0;
  };

  OpenAnswers answers;
  httplib::Server server;
  std::thread thread;
};

PageServer::PageServer(const ListenAddress& address, ServedPage content) : listener_(std::make_unique<Listener>()) {
  httplib::Server& server = listener_->server;
  const std::string token = IsLoopback(address.host) ? "" : MakeToken();
  server.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };
  // The library's own choice lets two programs listen at one port.
  server.set_socket_options([](socket_t socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  });
  // A connection that is kept keeps one of the threads.
  server.set_keep_alive_max_count(1);
  server.set_default_headers({{"Cache-Control", "no-store"},
                              {"X-Content-Type-Options", "nosniff"},
                              {"Referrer-Policy", "no-referrer"},
                              {"Cross-Origin-Resource-Policy", "same-origin"}});
  server.set_pre_routing_handler([token](const httplib::Request& request, httplib::Response& response) {
    std::string host = request.get_header_value("Host");
    host = host.substr(0, host.rfind(':'));
    const bool allowed = token.empty() ? host == "127.0.0.1" || host == "[::1]" || host == "localhost"
                                       : AreEqual(request.get_param_value("token"), token);
    if (allowed) return httplib::Server::HandlerResponse::Unhandled;
    response.status = kForbidden;
    response.set_content("knap: open the address that it has printed, with its token\n", "text/plain");
    return httplib::Server::HandlerResponse::Handled;
  });
  Listener::OpenAnswers& answers = listener_->answers;
  server.Get("/", [&answers, page = std::move(content.page)](const httplib::Request&, httplib::Response& response) {
    const std::shared_ptr<const void> answer = answers.Begin();
    Send(page(), "text/html; charset=utf-8", answer, &response);
  });
  server.Get("/news.json",
             [&answers, news = std::move(content.news)](const httplib::Request& request, httplib::Response& response) {
               const std::shared_ptr<const void> answer = answers.Begin();
               Send(news(request.get_param_value("seen")), "application/json", answer, &response);
             });
  errno = 0;
  const int port = address.port == 0                                 ? server.bind_to_any_port(address.host)
                   : server.bind_to_port(address.host, address.port) ? address.port
                                                                     : -1;
  if (port < 0) {
    throw std::runtime_error(fmt::format("cannot serve at {}:{}: {}", address.host, address.port,
                                         errno == 0 ? "no such address" : std::strerror(errno)));
  }
  url_ = fmt::format("http://{}:{}/{}", MakeHostText(address.host), port, token.empty() ? "" : "?token=" + token);
  listener_->thread = std::thread([&server] { server.listen_after_bind(); });
  // Before that it cannot be stopped.
  while (!server.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

PageServer::~PageServer() {
  listener_->answers.WaitUntilNone();
  listener_->server.stop();
  listener_->thread.join();
}

}  // namespace knap

// A page and what is new on it over HTTP, for browsers of this machine; for those of others only when asked, and then
// with a token in the address that nobody guesses.
#pragma once

#include <functional>
#include <memory>
#include <string>

namespace knap {

struct ListenAddress {
  std::string host = "127.0.0.1";
  int port = 0;  // 0: a free one
};

// "HOST:PORT" or "[HOST]:PORT"; std::invalid_argument, which says what is allowed, for anything else.
ListenAddress ParseListenAddress(const std::string& text);

// Called from the server's own threads.
struct ServedPage {
  std::function<std::string()> page;                         // HTML, at /
  std::function<std::string(const std::string& seen)> news;  // JSON, at /news.json?seen=…: what came after `seen`
};

class PageServer {
 public:
  // Serves from now on. Whoever comes to a loopback address needs no token, but must have asked for this machine by
  // name, which keeps pages of others from reading through the reader's browser. Throws std::runtime_error with one
  // line when the address cannot be listened at.
  PageServer(const ListenAddress& address, ServedPage content);
  // Every answer that has begun is written before the end.
  ~PageServer();
  PageServer(const PageServer&) = delete;
  PageServer& operator=(const PageServer&) = delete;

  // What to open, with the token where there is one.
  const std::string& url() const { return url_; }

 private:
  struct Listener;

  std::string url_;
  std::unique_ptr<Listener> listener_;
};

}  // namespace knap

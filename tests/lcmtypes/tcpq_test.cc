// tcpq://: the protocol's bytes, and transports that talk through a relay, ours or LCM's.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>

#include "lcmtypes/wire/open_transport.h"
#include "lcmtypes/wire/tcpq_relay.h"
#include "lcmtypes/wire/tcpq_transport.h"
#include "tests/support/held_port.h"
#include "tests/support/wait_for.h"

namespace knap {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// Ends what hangs; what is waited for comes.
constexpr std::int64_t kLongUs = 600'000'000;

std::vector<std::uint8_t> MakeBytes(const std::string& text) { return {text.begin(), text.end()}; }

std::string EncodePublish(const std::string& channel, const std::string& data) {
  return EncodeTcpqMessage(TcpqType::kPublish, channel, reinterpret_cast<const std::uint8_t*>(data.data()),
                           data.size());
}

TEST(TcpqStreamTest, MessagesComeBackHoweverTheStreamIsCut) {
  const std::string stream = EncodeTcpqHello(kTcpqClientMagic) +
                             EncodeTcpqMessage(TcpqType::kSubscribe, "KNAP_.*", nullptr, 0) +
                             EncodePublish("A", "data") + EncodePublish("", "") +
                             EncodeTcpqMessage(TcpqType::kUnsubscribe, "KNAP_.*", nullptr, 0);
  for (std::size_t cut = 1; cut <= stream.size(); ++cut) {
    TcpqReader reader(kTcpqClientMagic);
    std::vector<TcpqMessage> messages;
    for (std::size_t i = 0; i < stream.size(); i += cut) {
      reader.Append(stream.data() + i, std::min(cut, stream.size() - i));
      while (auto message = reader.Take()) messages.push_back(*message);
    }
    ASSERT_EQ(messages.size(), 4u) << cut;
    EXPECT_EQ(messages[0].type, TcpqType::kSubscribe);
    EXPECT_EQ(messages[0].channel, "KNAP_.*");
    EXPECT_EQ(messages[1].channel, "A");
    EXPECT_EQ(messages[1].data, MakeBytes("data"));
    EXPECT_EQ(messages[3].type, TcpqType::kUnsubscribe);
    EXPECT_FALSE(reader.broken());
  }
}

TEST(TcpqStreamTest, BrokenStreamsAreGivenUpAtOnce) {
  const std::string hello = EncodeTcpqHello(kTcpqClientMagic);
  const std::string zero(3, '\0');
  const std::string huge = "\x7f\xff\xff\xff";
  for (const std::string& stream : {
           EncodeTcpqHello(kTcpqServerMagic),               // not what a client says
           hello + zero + '\7' + zero + '\1',               // a type that does not exist
           hello + zero + '\1' + huge,                      // a channel of 2 GB
           hello + zero + '\1' + std::string(4, '\xff'),    // one whose length is -1
           hello + zero + '\1' + zero + '\1' + "A" + huge,  // data of 2 GB
       }) {
    TcpqReader reader(kTcpqClientMagic);
    reader.Append(stream.data(), stream.size());
    EXPECT_FALSE(reader.Take().has_value());
    EXPECT_TRUE(reader.broken());
  }
}

TEST(TcpqStreamTest, PatternsAreNamesAndPrefixes) {
  EXPECT_TRUE(MatchesTcpqPattern("KNAP_A", "KNAP_A"));
  EXPECT_FALSE(MatchesTcpqPattern("KNAP_A", "KNAP_AB"));
  EXPECT_TRUE(MatchesTcpqPattern("KNAP_.*", "KNAP_AB"));
  EXPECT_FALSE(MatchesTcpqPattern("KNAP_.*", "KNA"));
  EXPECT_TRUE(MatchesTcpqPattern(".*", ""));
  EXPECT_FALSE(MatchesTcpqPattern("(a+)+", "aaaa"));
}

TEST(TcpqStreamTest, UrlsAreParsed) {
  EXPECT_EQ(ParseTcpqUrl("tcpq://").host, "127.0.0.1");
  EXPECT_EQ(ParseTcpqUrl("tcpq://").port, 7700);
  EXPECT_EQ(ParseTcpqUrl("tcpq://node-1.lab:1234").host, "node-1.lab");
  EXPECT_EQ(ParseTcpqUrl("tcpq://:1234").port, 1234);
  for (const char* url : {"tcpq://a:0", "tcpq://a:70000", "tcpq://a:", "tcpq://a b", "tcpq://a:1x", "udpm://"}) {
    EXPECT_THROW(ParseTcpqUrl(url), std::invalid_argument) << url;
  }
  const SteadyClock clock;
  EXPECT_THROW(OpenTransport("memq://", {}, &clock), std::invalid_argument);
}

// A relay in a thread.
class RunningRelay {
 public:
  explicit RunningRelay(int port = 0, std::size_t memory = TcpqRelay::kMemory)
      : relay_("127.0.0.1", port, memory), thread_([this] { relay_.Run(stop_); }) {}
  ~RunningRelay() { Stop(); }
  void Stop() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }
  std::string url() const { return "tcpq://127.0.0.1:" + std::to_string(relay_.port()); }
  int port() const { return relay_.port(); }
  const TcpqRelayCounters& counters() const { return relay_.counters(); }  // after Stop

 private:
  std::atomic<bool> stop_{false};
  TcpqRelay relay_;
  std::thread thread_;
};

// A client that says what it likes.
class RawClient {
 public:
  explicit RawClient(int port) : RawClient() { Connect(port); }
  RawClient() : fd_(socket(AF_INET, SOCK_STREAM, 0)) {}
  void Connect(int port) const {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
      throw std::runtime_error("connect");
    }
  }
  ~RawClient() { close(fd_); }
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;
  void Send(const std::string& bytes) const { send(fd_, bytes.data(), bytes.size(), MSG_NOSIGNAL); }
  // Waits for the relay's greeting.
  bool IsGreeted() const {
    std::array<char, 8> hello{};
    return recv(fd_, hello.data(), hello.size(), MSG_WAITALL) == static_cast<ssize_t>(hello.size());
  }

 private:
  int fd_;
};

// Publishes until one message gets through: a subscription takes effect some time after the constructor, and a lost
// connection is made again. Takes away all that was sent up to then.
void WaitForPath(Transport* sender, Transport* receiver, const std::string& channel) {
  static int tries = 0;
  std::optional<Message> first;
  std::string latest;
  ASSERT_TRUE(WaitFor([&] {
    latest = std::to_string(++tries);
    sender->Publish(channel, MakeBytes(latest));
    first = receiver->Receive(5000);
    return first.has_value();
  }));
  for (auto message = first; message && message->bytes != MakeBytes(latest); message = receiver->Receive(kLongUs)) {
  }
}

const SteadyClock kClock;

TEST(TcpqTransportTest, CarriesMessagesOfItsOwnChannelsAlone) {
  const RunningRelay relay;
  TcpqTransport receiver(relay.url(), {"KNAP_A", "KNAP_AB"}, &kClock);
  TcpqTransport sender(relay.url(), {}, &kClock);
  WaitForPath(&sender, &receiver, "KNAP_A");
  for (const char* channel : {"KNAP_A", "KNAP_ABC", "KNAP_", "KNAP_AB", "OTHER"}) {
    sender.Publish(channel, MakeBytes(channel));
  }
  for (const char* channel : {"KNAP_A", "KNAP_AB"}) {
    const auto message = receiver.Receive(kLongUs);
    ASSERT_TRUE(message.has_value());
    EXPECT_EQ(message->channel, channel);
    EXPECT_EQ(message->bytes, MakeBytes(channel));
  }
  // What follows keeps its order: had another one been let through, it would come before.
  sender.Publish("KNAP_A", std::vector<std::uint8_t>(1301, 1));
  sender.Publish("KNAP_A", MakeBytes("good"));
  const auto message = receiver.Receive(kLongUs);
  ASSERT_TRUE(message.has_value());
  EXPECT_EQ(message->bytes, MakeBytes("good"));
  EXPECT_EQ(receiver.counters().dropped_too_large, 1);
}

// Nagle's algorithm against delayed acknowledgements would cost 40 ms each way.
void ExpectNoNagle() {
  int connections = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int fd = std::stoi(entry.path().filename());
    sockaddr_in peer{};
    socklen_t peer_size = sizeof(peer);
    if (getpeername(fd, reinterpret_cast<sockaddr*>(&peer), &peer_size) != 0 || peer.sin_family != AF_INET) continue;
    int on = 0, type = 0;
    socklen_t size = sizeof(on);
    getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &size);
    if (type != SOCK_STREAM) continue;
    ++connections;
    EXPECT_EQ(getsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, &size), 0);
    EXPECT_EQ(on, 1) << "descriptor " << fd;
  }
  EXPECT_GE(connections, 2);
}

// 200 small messages to and fro.
void ExpectRoundTrips(const std::string& url) {
  TcpqTransport a(url, {"TO_A"}, &kClock);
  TcpqTransport b(url, {"TO_B"}, &kClock);
  WaitForPath(&a, &b, "TO_B");
  WaitForPath(&b, &a, "TO_A");
  std::atomic<bool> stop{false};
  std::thread echo([&] {
    while (!stop) {
      if (const auto message = b.Receive(10'000)) b.Publish("TO_A", message->bytes);
    }
  });
  ExpectNoNagle();
  int answered = 0;
  for (int i = 0; i < 200; ++i) {
    a.Publish("TO_B", MakeBytes(std::to_string(i)));
    const auto answer = a.Receive(kLongUs);
    answered += answer && answer->bytes == MakeBytes(std::to_string(i)) ? 1 : 0;
  }
  stop = true;
  echo.join();
  EXPECT_EQ(answered, 200);
}

TEST(TcpqTransportTest, RoundTripsThroughOurRelay) { ExpectRoundTrips(RunningRelay().url()); }

TEST(TcpqTransportTest, RoundTripsThroughLcmsJavaRelay) {
#ifndef KNAP_JAVA
  GTEST_SKIP() << "no java or no LCM jar: LCM's own relay is not tried";
#else
  const HeldPort port;
  const std::string number = std::to_string(port.number());
  const pid_t java = fork();
  if (java == 0) {
    execl(KNAP_JAVA, KNAP_JAVA, "-Djava.net.preferIPv4Stack=true", "-cp", KNAP_LCM_JAR, "lcm.lcm.TCPService",
          number.c_str(), nullptr);
    _exit(127);
  }
  const std::string url = "tcpq://127.0.0.1:" + number;
  ASSERT_TRUE(WaitFor([&] {
    try {
      const TcpqTransport probe(url, {}, &kClock);
      return true;
    } catch (const std::runtime_error&) {
      return false;
    }
  }));
  ExpectRoundTrips(url);
  kill(java, SIGKILL);
  waitpid(java, nullptr, 0);
#endif
}

TEST(TcpqTransportTest, ComesBackWhenTheRelayDoes) {
  const HeldPort port;
  auto relay = std::make_unique<RunningRelay>(port.number());
  TcpqTransport receiver(relay->url(), {"KNAP_A"}, &kClock);
  TcpqTransport sender(relay->url(), {}, &kClock);
  WaitForPath(&sender, &receiver, "KNAP_A");
  relay.reset();
  // Into the void, without a signal.
  ASSERT_TRUE(WaitFor([&] {
    sender.Publish("KNAP_A", MakeBytes("lost"));
    return sender.counters().publish_failures > 0;
  }));
  const RunningRelay next(port.number());
  WaitForPath(&sender, &receiver, "KNAP_A");
  sender.Publish("KNAP_A", MakeBytes("found"));
  const auto message = receiver.Receive(kLongUs);
  ASSERT_TRUE(message.has_value());
  EXPECT_EQ(message->bytes, MakeBytes("found"));
}

TEST(TcpqTransportTest, MissingRelayIsToldWithTheRemedy) {
  const HeldPort port;
  const std::string number = std::to_string(port.number());
  try {
    const TcpqTransport transport("tcpq://127.0.0.1:" + number, {}, &kClock);
    FAIL() << "nothing was thrown";
  } catch (const std::runtime_error& e) {
    EXPECT_THAT(e.what(), AllOf(HasSubstr(number), HasSubstr("knap-relay")));
  }
}

TEST(TcpqRelayTest, ClientThatDoesNotReadHoldsUpNobody) {
  RunningRelay relay;
  RawClient frozen(relay.port());
  frozen.Send(EncodeTcpqHello(kTcpqClientMagic) + EncodeTcpqMessage(TcpqType::kSubscribe, ".*", nullptr, 0));
  TcpqTransport receiver(relay.url(), {"LAST"}, &kClock);
  TcpqTransport sender(relay.url(), {}, &kClock);
  WaitForPath(&sender, &receiver, "LAST");
  const std::vector<std::uint8_t> bytes(60'000, 1);
  for (int i = 0; i < 400; ++i) {  // 24 MB: more than the relay's and the kernel's buffers hold
    sender.Publish("BULK", bytes);
    if (i % 20 == 0) WaitForPath(&sender, &receiver, "LAST");  // at the relay's speed
  }
  WaitForPath(&sender, &receiver, "LAST");
  EXPECT_EQ(sender.counters().publish_failures, 0);
  relay.Stop();
  EXPECT_GT(relay.counters().dropped, 0);
}

// Ten clients that listen to everything and read nothing: together they would hold 40 MB, each for itself within its
// bound. The relay holds 2 MB, and whoever reads gets what is sent.
TEST(TcpqRelayTest, MemoryForAllClientsTogetherIsBounded) {
  constexpr std::size_t kMemory = 2 << 20;
  RunningRelay relay(0, kMemory);
  std::deque<RawClient> frozen;
  for (int i = 0; i < 10; ++i) {
    frozen.emplace_back(relay.port());
    frozen.back().Send(EncodeTcpqHello(kTcpqClientMagic) + EncodeTcpqMessage(TcpqType::kSubscribe, "BULK", nullptr, 0));
  }
  TcpqTransport receiver(relay.url(), {"PACE"}, &kClock);
  TcpqTransport sender(relay.url(), {}, &kClock);
  WaitForPath(&sender, &receiver, "PACE");
  const std::vector<std::uint8_t> bytes(60'000, 1);
  int tries = 0;
  for (int i = 0; i < 400; ++i) {  // 24 MB for each of them: more than the kernel's buffers hold
    sender.Publish("BULK", bytes);
    // At the relay's speed: this comes back when all before it has been taken. It may be lost, for memory is short.
    ASSERT_TRUE(WaitFor([&] {
      const std::vector<std::uint8_t> pace = MakeBytes(std::to_string(++tries));
      sender.Publish("PACE", pace);
      std::optional<Message> message = receiver.Receive(100'000);
      while (message && message->bytes != pace) message = receiver.Receive(100'000);
      return message.has_value();
    }));
  }
  relay.Stop();
  EXPECT_GT(relay.counters().hungry, 0);
  EXPECT_GT(relay.counters().most_held, static_cast<std::int64_t>(kMemory / 2));
  EXPECT_LE(relay.counters().most_held, static_cast<std::int64_t>(kMemory));
}

// A client knocks and the process has no descriptor left: the knock waits in the kernel's queue, and whoever asks the
// kernel at once again does so without end. It is let in when there is a descriptor, and the others are served
// meanwhile.
TEST(TcpqRelayTest, WithoutDescriptorsItWaitsAndServes) {
  RunningRelay relay;
  TcpqTransport receiver(relay.url(), {"KNAP_A"}, &kClock);
  TcpqTransport sender(relay.url(), {}, &kClock);
  WaitForPath(&sender, &receiver, "KNAP_A");
  const RawClient late;
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  std::vector<int> taken;  // every descriptor below the limit
  const rlimit low{64, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &low), 0);
  for (int fd = dup(0); fd >= 0; fd = dup(0)) taken.push_back(fd);
  const std::int64_t begin_us = kClock.now_us();
  late.Connect(relay.port());
  int answered = 0;
  for (int i = 0; i < 300; ++i) {  // each makes the relay look at its sockets, the knock among them
    sender.Publish("KNAP_A", MakeBytes("served"));
    answered += receiver.Receive(kLongUs) ? 1 : 0;
  }
  EXPECT_EQ(answered, 300);
  const std::int64_t waited_us = kClock.now_us() - begin_us;
  for (const int fd : taken) close(fd);
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &before), 0);
  EXPECT_TRUE(late.IsGreeted());
  relay.Stop();
  EXPECT_GT(relay.counters().accept_failures, 0);
  EXPECT_LE(relay.counters().accept_failures, waited_us / 100'000 + 2);  // one a pause, however fast the machine is
}

TEST(TcpqRelayTest, StrangersBytesAreSurvived) {
  RunningRelay relay;
  TcpqTransport receiver(relay.url(), {"KNAP_A"}, &kClock);
  TcpqTransport sender(relay.url(), {}, &kClock);
  std::mt19937 random(3);
  for (int i = 0; i < 200; ++i) {
    std::string bytes(1 + random() % 3000, '\0');
    for (char& c : bytes) c = static_cast<char>(random() % (i % 2 == 0 ? 256 : 4));
    RawClient stranger(relay.port());
    stranger.Send((i % 4 < 2 ? EncodeTcpqHello(kTcpqClientMagic) : "") + bytes);
  }
  // Every one of these takes the relay at least one turn, and in every turn it looks at one stranger or more.
  for (int i = 0; i < 1000; ++i) WaitForPath(&sender, &receiver, "KNAP_A");
  relay.Stop();
  EXPECT_GT(relay.counters().refused, 100);
}

}  // namespace
}  // namespace knap

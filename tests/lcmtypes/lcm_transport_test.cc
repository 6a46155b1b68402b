#include "lcmtypes/wire/lcm_transport.h"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>

#include "knap/preflight_t.hpp"
#include "lcmtypes/wire/multicast.h"
#include "tests/support/catch_line.h"
#include "tests/support/own_lcm_url.h"

namespace knap {
namespace {

using ::testing::HasSubstr;

// Ends what hangs; what is waited for comes.
constexpr std::int64_t kLongUs = 600'000'000;

std::vector<std::uint8_t> MakeBytes(const std::string& text) { return {text.begin(), text.end()}; }

// Sends bare datagrams to a bus, as a stranger or a broken program would.
class RawSender {
 public:
  explicit RawSender(const std::string& url) : address_(ParseUdpmUrl(url)), fd_(socket(AF_INET, SOCK_DGRAM, 0)) {
    const unsigned char ttl = 0;
    setsockopt(fd_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof(ttl));
  }
  ~RawSender() { close(fd_); }
  void Send(const std::string& datagram) const {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(static_cast<std::uint16_t>(address_.port));
    inet_pton(AF_INET, address_.group.c_str(), &to.sin_addr);
    sendto(fd_, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof(to));
  }

 private:
  UdpmAddress address_;
  int fd_;
};

std::string MakeBigEndian(std::uint32_t value, int bytes) {
  std::string s;
  for (int shift = 8 * (bytes - 1); shift >= 0; shift -= 8) s.push_back(static_cast<char>((value >> shift) & 0xff));
  return s;
}

// The header of an LCM fragment: magic, sequence, message size, offset, number of this one, number of all.
std::string MakeFragment(std::uint32_t sequence, std::uint32_t size, std::uint32_t offset, std::uint32_t index,
                         std::uint32_t count, const std::string& rest) {
  return "LC03" + MakeBigEndian(sequence, 4) + MakeBigEndian(size, 4) + MakeBigEndian(offset, 4) +
         MakeBigEndian(index, 2) + MakeBigEndian(count, 2) + rest;
}

class LcmTransportTest : public ::testing::Test {
 protected:
  const std::string url_ = MakeOwnLcmUrl();
  SteadyClock clock_;
};

TEST_F(LcmTransportTest, CarriesMessagesOfItsOwnChannelsAlone) {
  LcmTransport receiver(url_, {"KNAP_A", "KNAP_AB"}, &clock_);
  LcmTransport sender(url_, {}, &clock_);
  const std::int64_t before_us = clock_.now_us();
  for (const char* channel : {"KNAP_A", "KNAP_ABC", "KNAP_", "KNAP_AB", "OTHER"})
    sender.Publish(channel, MakeBytes(channel));
  for (const char* channel : {"KNAP_A", "KNAP_AB"}) {
    const auto message = receiver.Receive(kLongUs);
    ASSERT_TRUE(message.has_value());
    EXPECT_EQ(message->channel, channel);
    EXPECT_EQ(message->bytes, MakeBytes(channel));
    EXPECT_GE(message->arrival_us, before_us);
    EXPECT_LE(message->arrival_us, clock_.now_us());
  }
  // One sender's messages keep their order: had another one been let through, it would come before this.
  sender.Publish("KNAP_A", MakeBytes("last"));
  const auto last = receiver.Receive(kLongUs);
  ASSERT_TRUE(last.has_value());
  EXPECT_EQ(last->bytes, MakeBytes("last"));
  EXPECT_EQ(receiver.counters().received, 3);
  EXPECT_EQ(sender.counters().published, 6);
  EXPECT_GT(receiver.receive_buffer_size(), 100'000);
}

TEST_F(LcmTransportTest, ReceiveBlocksUntilAMessageTimeoutOrWake) {
  LcmTransport transport(url_, {"KNAP_A"}, &clock_);
  std::int64_t begin_us = clock_.now_us();
  EXPECT_FALSE(transport.Receive(50'000).has_value());
  EXPECT_GE(clock_.now_us() - begin_us, 50'000);
  begin_us = clock_.now_us();
  for (int i = 0; i < 100; ++i) {  // before the wait or in it, as it happens
    std::thread waker([&] { transport.Wake(); });
    EXPECT_FALSE(transport.Receive(kLongUs).has_value());
    waker.join();
  }
  transport.Wake();  // before the wait: not lost
  EXPECT_FALSE(transport.Receive(kLongUs).has_value());
  EXPECT_LT(clock_.now_us() - begin_us, kLongUs);  // no wait ended by itself
}

TEST_F(LcmTransportTest, BurstsFitTheBuffers) {
  LcmTransport receiver(url_, {"KNAP_A"}, &clock_);
  LcmTransport sender(url_, {}, &clock_);
  const std::vector<std::uint8_t> bytes(1300, 1);
  // The default buffer holds 92, the default queue 30. One takes 2304 bytes of what the kernel granted, if the
  // receiving thread gets no processor meanwhile.
  const int burst = std::min(200, receiver.receive_buffer_size() / 2304);
  ASSERT_GT(burst, 92);
  for (int i = 0; i < burst; ++i) sender.Publish("KNAP_A", bytes);
  for (int i = 0; i < burst; ++i) ASSERT_TRUE(receiver.Receive(kLongUs).has_value()) << i;
}

TEST_F(LcmTransportTest, MessagesBeyondTheLimitAreDropped) {
  LcmTransport receiver(url_, {"KNAP_A"}, &clock_);
  LcmTransport sender(url_, {}, &clock_);
  sender.Publish("KNAP_A", std::vector<std::uint8_t>(1301, 1));
  sender.Publish("KNAP_A", MakeBytes("good"));
  const auto message = receiver.Receive(kLongUs);
  ASSERT_TRUE(message.has_value());
  EXPECT_EQ(message->bytes, MakeBytes("good"));
  EXPECT_EQ(receiver.counters().dropped_too_large, 1);
}

// Each of these crashes or fools liblcm 1.3.1 when it gets them.
TEST_F(LcmTransportTest, HostileDatagramsDoNotReachTheLibrary) {
  LcmTransport receiver(url_, {"KNAP_A"}, &clock_);
  const RawSender raw(url_);
  const std::string channel("KNAP_A\0", 7);
  // A fragment that comes twice: taken for two, it completes a message of which 60 bytes never came.
  raw.Send(MakeFragment(1, 100, 0, 0, 2, channel + std::string(40, 'x')));
  raw.Send(MakeFragment(1, 100, 0, 0, 2, channel + std::string(40, 'x')));
  // A fragment whose offset and length together wrap around to a place within the message.
  raw.Send(MakeFragment(2, 100, 0, 0, 2, channel + std::string(40, 'x')));
  raw.Send(MakeFragment(2, 100, 0xfffffff0, 1, 2, std::string(100, 'y')));
  // Whole messages without an end of the channel's name, and with a name of ours that goes on.
  raw.Send("LC02" + MakeBigEndian(1, 4) + "KNAP_A");
  raw.Send("LC02" + MakeBigEndian(1, 4) + std::string(1000, 'c'));
  raw.Send("LC02" + MakeBigEndian(1, 4));
  raw.Send("LC02");
  raw.Send("");
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    std::string datagram(random() % 200, '\0');
    for (char& c : datagram) c = static_cast<char>(random());
    raw.Send((i % 3 == 0 ? "LC02" : i % 3 == 1 ? "LC03" : "") + datagram);
  }
  // All of them were sent before this, and none of them comes before it.
  LcmTransport sender(url_, {}, &clock_);
  sender.Publish("KNAP_A", MakeBytes("alive"));
  const auto message = receiver.Receive(kLongUs);
  ASSERT_TRUE(message.has_value());
  EXPECT_EQ(message->bytes, MakeBytes("alive"));
}

TEST(MulticastTest, UrlsAreParsed) {
  const UdpmAddress address = ParseUdpmUrl("udpm://239.1.2.3:1234?ttl=1&recv_buf_size=4096");
  EXPECT_EQ(address.group, "239.1.2.3");
  EXPECT_EQ(address.port, 1234);
  EXPECT_EQ(address.ttl(), 1);
  EXPECT_EQ(address.MakeUrl(), "udpm://239.1.2.3:1234?recv_buf_size=4096&ttl=1");
  EXPECT_EQ(ParseUdpmUrl("udpm://").MakeUrl(), "udpm://239.255.76.67:7667");
  EXPECT_EQ(ParseUdpmUrl(kDefaultLcmUrl).ttl(), 0);
}

TEST(MulticastTest, WrongUrlsAreNamed) {
  const auto parse = [](const char* url) { return CatchLine([=] { ParseUdpmUrl(url); }); };
  EXPECT_THAT(parse("udpm://10.0.0.1:7667"), HasSubstr("'10.0.0.1' is no multicast address"));
  EXPECT_THAT(parse("udpm://239.255.76.67:70000"), HasSubstr("the port is '70000'"));
  EXPECT_THAT(parse("udpm://239.255.76.67:7667?ttl=x"), HasSubstr("ttl is 'x'"));
  EXPECT_THAT(parse("udpm://239.255.76.67:7667?tll=1"), HasSubstr("option 'tll=1'"));
  EXPECT_THAT(parse("http://a"), HasSubstr("does not begin with udpm://"));
}

TEST(MulticastTest, ChoosesFlagThenEnvironmentThenFallback) {
  unsetenv("LCM_DEFAULT_URL");
  EXPECT_EQ(ChooseLcmUrl("flag", "fallback"), "flag");
  EXPECT_EQ(ChooseLcmUrl("", "fallback"), "fallback");
  setenv("LCM_DEFAULT_URL", "environment", 1);
  EXPECT_EQ(ChooseLcmUrl("flag", "fallback"), "flag");
  EXPECT_EQ(ChooseLcmUrl("", "fallback"), "environment");
  unsetenv("LCM_DEFAULT_URL");
}

// lcm-spy and every other listener can decode what the check sends.
TEST(MulticastTest, CheckSendsATypedMessage) {
  const std::string url = MakeOwnLcmUrl();
  const SteadyClock clock;
  LcmTransport listener(url, {kPreflightChannel}, &clock);
  CheckMulticast(ParseUdpmUrl(url));
  const auto message = listener.Receive(kLongUs);
  ASSERT_TRUE(message.has_value());
  preflight_t preflight{};
  const int size = static_cast<int>(message->bytes.size());
  EXPECT_EQ(preflight.decode(message->bytes.data(), 0, size), size);
  EXPECT_NE(preflight.nonce, 0);
}

// A network namespace of one's own has no route for multicast, and a loopback that is down.
TEST(MulticastTest, MissingRouteIsToldWithTheRemedy) {
  int line[2];
  ASSERT_EQ(pipe(line), 0);
  const pid_t child = fork();
  if (child == 0) {
    if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) _exit(2);
    const std::string text = CatchLine([] { CheckMulticast(ParseUdpmUrl(kDefaultLcmUrl)); });
    _exit(write(line[1], text.data(), text.size()) == static_cast<ssize_t>(text.size()) ? 0 : 3);
  }
  close(line[1]);
  std::string text(2000, '\0');
  const ssize_t size = read(line[0], text.data(), text.size());
  close(line[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (WEXITSTATUS(status) == 2) GTEST_SKIP() << "this machine lets nobody make network namespaces";
  ASSERT_GT(size, 0);
  text.resize(static_cast<std::size_t>(size));
  EXPECT_THAT(text, HasSubstr("does not work on this machine"));
  EXPECT_THAT(text, HasSubstr("ip link set lo up; ip route add 224.0.0.0/4 dev lo"));
  EXPECT_THAT(text, HasSubstr("unshare -Urn"));
}

}  // namespace
}  // namespace knap

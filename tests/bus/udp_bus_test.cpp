// SPDX-License-Identifier: Apache-2.0
#include "bus/udp_bus.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <random>

#include "bus/node.hpp"
#include "network_namespace.hpp"

namespace cairn::bus {
namespace {

std::string url_error(const std::string& url) {
  const auto parsed = parse_udp_url(url);
  return parsed ? "" : parsed.error().message;
}

TEST(UdpUrl, AGoodOneIsTakenApart) {
  const auto url = parse_udp_url("udpm://239.1.2.3:7700?ttl=1&recv_buf_size=106496").value();
  EXPECT_EQ(url.group, "239.1.2.3");
  EXPECT_EQ(url.port, 7700);
  EXPECT_EQ(url.ttl, 1);
  EXPECT_EQ(url.recv_buf_size, 106496);
  EXPECT_EQ(parse_udp_url("udpm://239.1.2.3:7700").value().ttl, 0);
}

TEST(UdpUrl, ABadOneIsToldWhichPartIsWrong) {
  EXPECT_NE(url_error("tcp://1.2.3.4:7700").find("not of the form"), std::string::npos);
  EXPECT_NE(url_error("udpm://10.0.0.1:7700").find("'10.0.0.1' is not a multicast address"),
            std::string::npos);
  EXPECT_NE(url_error("udpm://239.1.2.3:99999").find("port must be"), std::string::npos);
  EXPECT_NE(url_error("udpm://239.1.2.3").find("port must be"), std::string::npos);
  EXPECT_NE(url_error("udpm://239.1.2.3:7700?tttl=1").find("unknown option 'tttl'"),
            std::string::npos);
  EXPECT_NE(url_error("udpm://239.1.2.3:7700?ttl=x").find("ttl must be"), std::string::npos);
  EXPECT_NE(open_bus("file:///nowhere?in=3").error().message.find("unknown option"),
            std::string::npos);
}

constexpr const char* kUrl = "udpm://239.255.76.67:7701?ttl=0&recv_buf_size=106496";

class UdpBusTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!testing::enter_network_namespace()) GTEST_SKIP() << testing::kNoNamespace;
  }
};

TEST_F(UdpBusTest, WithoutARouteTheMendingCommandIsNamed) {
  const auto bus = open_udp_bus(parse_udp_url(kUrl).value());
  ASSERT_FALSE(bus);
  EXPECT_NE(bus.error().message.find("no route for multicast"), std::string::npos)
      << bus.error().message;
  EXPECT_NE(bus.error().message.find("ip route add 224.0.0.0/4 dev lo"), std::string::npos);
}

TEST_F(UdpBusTest, ATakenPortIsNamed) {
  ASSERT_TRUE(testing::add_multicast_route());
  const int holder = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in any{};
  any.sin_family = AF_INET;
  any.sin_port = htons(7701);
  ASSERT_EQ(::bind(holder, reinterpret_cast<const sockaddr*>(&any), sizeof(any)), 0);
  const auto bus = open_udp_bus(parse_udp_url(kUrl).value());
  ::close(holder);
  ASSERT_FALSE(bus);
  EXPECT_NE(bus.error().message.find("cannot listen on port 7701"), std::string::npos)
      << bus.error().message;
  EXPECT_NE(bus.error().message.find("ss -ulpn"), std::string::npos);
}

TEST_F(UdpBusTest, ABufferTooSmallForImagesIsSaidAndMendable) {
  ASSERT_TRUE(testing::add_multicast_route());
  std::string warning;
  ASSERT_TRUE(open_udp_bus(parse_udp_url("udpm://239.255.76.67:7701?recv_buf_size=8192").value(),
                           &warning));
  EXPECT_NE(warning.find("sysctl -w net.core.rmem_max"), std::string::npos) << warning;
}

TEST_F(UdpBusTest, WhoListensToEverythingGetsEachMessageOnce) {
  ASSERT_TRUE(testing::add_multicast_route());
  const auto sender = open_bus(kUrl).value();
  const auto receiver = open_bus(kUrl).value();
  ASSERT_TRUE(receiver->subscribe("CLOCK"));
  ASSERT_TRUE(receiver->subscribe(kAllChannels));
  ASSERT_TRUE(receiver->subscribe("POSE"));
  for (const char* channel : {"CLOCK", "POSE", "STOP", "END"})
    ASSERT_TRUE(sender->publish(channel, std::vector<std::uint8_t>(20)));
  std::vector<RawMessage> received;
  while (received.empty() || received.back().channel != "END")
    receiver->receive(1'000'000, received);
  std::vector<std::string> channels;
  for (const RawMessage& message : received) channels.push_back(message.channel);
  EXPECT_EQ(channels, (std::vector<std::string>{"CLOCK", "POSE", "STOP", "END"}));
}

// Sends datagrams straight to the group, as anybody on the machine can.
class Stranger {
 public:
  Stranger() : fd_{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)} {
    group_.sin_family = AF_INET;
    group_.sin_port = htons(7701);
    ::inet_pton(AF_INET, "239.255.76.67", &group_.sin_addr);
  }
  Stranger(const Stranger&) = delete;
  Stranger& operator=(const Stranger&) = delete;
  ~Stranger() { ::close(fd_); }
  void send(const std::vector<std::uint8_t>& bytes) const {
    ::sendto(fd_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&group_),
             sizeof(group_));
  }

 private:
  int fd_;
  sockaddr_in group_{};
};

void append_u32(std::vector<std::uint8_t>& bytes, std::uint32_t value) {
  for (const int shift : {24, 16, 8, 0}) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

// H-BUS-1: junk on the wire.
TEST_F(UdpBusTest, TenThousandJunkDatagramsAreRefusedAndTheNextMessageIsHandled) {
  ASSERT_TRUE(testing::add_multicast_route());
  const auto bus = open_bus(kUrl).value();
  const SteadyClock clock;
  Node node("tested", *bus, clock, {}, 1);
  int handled = 0;
  node.on<channels::Pose>([&](const pose_t&) { ++handled; });
  ASSERT_TRUE(node.wiring());
  const Stranger stranger;
  std::mt19937 random(9);
  for (int i = 0; i < 10'000; ++i) {
    std::vector<std::uint8_t> datagram;
    const int kind = i % 4;
    if (kind == 1) append_u32(datagram, 0x4c433032);  // a short message's magic number
    if (kind == 2) append_u32(datagram, 0x4c433033);  // a fragment's magic number
    if (kind == 3) {                                  // a whole message with junk inside
      append_u32(datagram, 0x4c433032);
      append_u32(datagram, static_cast<std::uint32_t>(i));
      for (const char c : {'P', 'O', 'S', 'E', '\0'})
        datagram.push_back(static_cast<std::uint8_t>(c));
    }
    for (auto n = random() % 200; n > 0; --n)
      datagram.push_back(static_cast<std::uint8_t>(random()));
    stranger.send(datagram);
    if (i % 100 == 99) node.spin_once(1000);
  }
  const auto refused = [&] { return node.counts().find("POSE")->second.refused; };
  pose_t pose{};
  ASSERT_TRUE(bus->publish("POSE", encode(pose).value()));
  while (handled == 0) node.spin_once(100'000);
  EXPECT_EQ(handled, 1);
  EXPECT_GE(refused(), 2000)
      << "of the 2500 that LCM could hand on; the kernel may drop some of a flood";
}

TEST_F(UdpBusTest, FramesWithinTheBudgetArriveOnAStockKernelsBuffer) {
  ASSERT_TRUE(testing::add_multicast_route());
  const auto sender = open_bus(kUrl).value();
  const auto receiver = open_bus(kUrl).value();
  ASSERT_TRUE(receiver->subscribe("STEREO_FRAME"));
  const std::vector<std::uint8_t> frame(115'000, 7);
  std::vector<RawMessage> received;
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(sender->publish("STEREO_FRAME", frame));
    while (received.size() < static_cast<std::size_t>(i) + 1)
      receiver->receive(1'000'000, received);
  }
  EXPECT_EQ(received.size(), 100U);
  EXPECT_EQ(received.back().bytes, frame);
}

}  // namespace
}  // namespace cairn::bus

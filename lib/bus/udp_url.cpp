// SPDX-License-Identifier: Apache-2.0
#include "bus/udp_url.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>

namespace cairn::bus {
namespace {

constexpr const char* kForm = "udpm://GROUP:PORT?ttl=0&recv_buf_size=BYTES";
/// What a stock kernel gives: enough for messages under 115 kB at camera rate.
constexpr int kSmallestBuffer_bytes = 212'992;

bool parse_int(std::string_view text, int min, int max, int& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() && value >= min && value <= max;
}

Result<void> set_option(UdpUrl& parsed, const std::string& url, std::string_view option) {
  const std::size_t equals = option.find('=');
  const std::string_view key = option.substr(0, equals);
  const std::string_view value = equals == std::string_view::npos ? "" : option.substr(equals + 1);
  if (key == "ttl") {
    if (!parse_int(value, 0, 255, parsed.ttl)) return fail(url + ": ttl must be 0 to 255");
  } else if (key == "recv_buf_size") {
    if (!parse_int(value, 1024, 1 << 30, parsed.recv_buf_size)) {
      return fail(url + ": recv_buf_size must be 1024 to 1073741824 bytes");
    }
  } else {
    return fail(url + ": unknown option '" + std::string(key) + "' (known: ttl, recv_buf_size)");
  }
  return {};
}

class Socket {
 public:
  Socket() : fd_{::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)} {}
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  ~Socket() {
    if (fd_ >= 0) ::close(fd_);
  }
  [[nodiscard]] int fd() const { return fd_; }

 private:
  int fd_;
};

constexpr const char* kMendRoute =
    "  mend: sudo ip link set lo up && sudo ip route add 224.0.0.0/4 dev lo";

Result<void> check_route(const UdpUrl& url, const sockaddr_in& group) {
  const Socket probe;
  if (::connect(probe.fd(), reinterpret_cast<const sockaddr*>(&group), sizeof(group)) == 0)
    return {};
  return fail(url.text() + ": no route for multicast (" + std::strerror(errno) + ")\n" +
              kMendRoute);
}

Result<void> check_bind_and_join(const UdpUrl& url, const in_addr& group) {
  const Socket probe;
  const int yes = 1;
  ::setsockopt(probe.fd(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  sockaddr_in any{};
  any.sin_family = AF_INET;
  any.sin_addr.s_addr = htonl(INADDR_ANY);
  any.sin_port = htons(static_cast<std::uint16_t>(url.port));
  if (::bind(probe.fd(), reinterpret_cast<const sockaddr*>(&any), sizeof(any)) != 0) {
    const int problem = errno;
    std::string message = url.text() + ": cannot listen on port " + std::to_string(url.port) +
                          " (" + std::strerror(problem) + ")";
    if (problem == EADDRINUSE) {
      message += "\n  another program holds it alone; who: sudo ss -ulpn 'sport = :" +
                 std::to_string(url.port) + "'; or choose another port with --lcm-url";
    }
    return fail(message);
  }
  ip_mreq membership{};
  membership.imr_multiaddr = group;
  membership.imr_interface.s_addr = htonl(INADDR_ANY);
  if (::setsockopt(probe.fd(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof(membership)) !=
      0) {
    return fail(url.text() + ": cannot join the multicast group (" + std::strerror(errno) + ")\n" +
                kMendRoute);
  }
  return {};
}

std::string check_buffer(const UdpUrl& url) {
  const Socket probe;
  ::setsockopt(probe.fd(), SOL_SOCKET, SO_RCVBUF, &url.recv_buf_size, sizeof(url.recv_buf_size));
  int granted = 0;
  socklen_t size = sizeof(granted);
  ::getsockopt(probe.fd(), SOL_SOCKET, SO_RCVBUF, &granted, &size);
  if (granted >= kSmallestBuffer_bytes) return "";
  return "the receive buffer is only " + std::to_string(granted) + " bytes; below " +
         std::to_string(kSmallestBuffer_bytes) +
         " images get lost\n  mend: sudo sysctl -w net.core.rmem_max=4194304, and no recv_buf_size "
         "under 106496 in the URL";
}

}  // namespace

std::string UdpUrl::text() const {
  return "udpm://" + group + ":" + std::to_string(port) + "?ttl=" + std::to_string(ttl) +
         "&recv_buf_size=" + std::to_string(recv_buf_size);
}

Result<UdpUrl> parse_udp_url(const std::string& url) {
  constexpr std::string_view kScheme = "udpm://";
  std::string_view rest = url;
  if (!rest.starts_with(kScheme)) return fail(url + ": is not of the form " + kForm);
  rest.remove_prefix(kScheme.size());
  const std::size_t question = rest.find('?');
  std::string_view options = question == std::string_view::npos ? "" : rest.substr(question + 1);
  const std::string_view address = rest.substr(0, question);
  const std::size_t colon = address.find(':');
  UdpUrl parsed;
  parsed.group = std::string(address.substr(0, colon));
  if (colon == std::string_view::npos ||
      !parse_int(address.substr(colon + 1), 1, 65535, parsed.port)) {
    return fail(url + ": the port must be 1 to 65535 (form: " + kForm + ")");
  }
  in_addr group{};
  if (::inet_pton(AF_INET, parsed.group.c_str(), &group) != 1 ||
      !IN_MULTICAST(ntohl(group.s_addr))) {
    return fail(url + ": '" + parsed.group +
                "' is not a multicast address (224.0.0.0 to 239.255.255.255)");
  }
  while (!options.empty()) {
    const std::size_t ampersand = options.find('&');
    if (auto set = set_option(parsed, url, options.substr(0, ampersand)); !set) {
      return tl::make_unexpected(set.error());
    }
    options = ampersand == std::string_view::npos ? "" : options.substr(ampersand + 1);
  }
  return parsed;
}

Result<std::string> check_network(const UdpUrl& url) {
  sockaddr_in group{};
  group.sin_family = AF_INET;
  group.sin_port = htons(static_cast<std::uint16_t>(url.port));
  ::inet_pton(AF_INET, url.group.c_str(), &group.sin_addr);
  if (auto route = check_route(url, group); !route) return tl::make_unexpected(route.error());
  if (auto joined = check_bind_and_join(url, group.sin_addr); !joined) {
    return tl::make_unexpected(joined.error());
  }
  return check_buffer(url);
}

}  // namespace cairn::bus

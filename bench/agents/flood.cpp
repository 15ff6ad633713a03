// SPDX-License-Identifier: Apache-2.0
// One client that floods a server on loopback, in one thread; see docs/benchmarks.md.
//
//   flood connects PORT RATE SECONDS BODY   silent connections per second; every other one stays
//                                           open, up to 1,000
//   flood logins   PORT RATE SECONDS BODY   observers that join per second; the last 1,000 stay
//   flood pings    PORT RATE SECONDS BODY   messages per second of one agent with that body
//   flood acts     PORT RATE SECONDS BODY   acts per second: the body a<n> pushes the item p<n>
//   flood sink     PORT                     a server that answers any input
//
// An agent reconnects at once when the server disconnects it. Prints one JSON object.

#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/epoll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <deque>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

namespace {

constexpr size_t kLeftOpen = 1000;
constexpr size_t kBatchBytes = 1 << 16;  ///< Size of one write [B].
constexpr double kPauseSeconds = 1e-3;   ///< Sleep time when the flood is ahead of its rate [s].

double Now() {
  using std::chrono::steady_clock;
  return std::chrono::duration<double>(steady_clock::now().time_since_epoch()).count();
}

[[noreturn]] void Fail(const std::string& what) {
  throw std::runtime_error(what + ": " + std::strerror(errno));
}

sockaddr_in Loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

/// A socket that leaves no state in the system when it is closed, so that the system always has
/// free ports.
class Connection {
 public:
  explicit Connection(int port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    const linger reset{1, 0};
    setsockopt(socket_, SOL_SOCKET, SO_LINGER, &reset, sizeof reset);
    const sockaddr_in address = Loopback(port);
    if (connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
      Fail("cannot connect to port " + std::to_string(port));
    }
  }
  Connection(Connection&& other) noexcept : socket_(std::exchange(other.socket_, -1)) {}
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  ~Connection() {
    if (socket_ >= 0) close(socket_);
  }

  void DoNotBlock() const { fcntl(socket_, F_SETFL, O_NONBLOCK); }

  /// Returns the number of bytes accepted; -1 if the server has ended the connection.
  ssize_t Write(const char* bytes, size_t size) const {
    const ssize_t count = send(socket_, bytes, size, MSG_NOSIGNAL);
    return count >= 0 ? count : errno == EAGAIN ? 0 : -1;
  }

  /// Discards received bytes. Returns false if the server has ended the connection.
  bool Drain() const {
    char bytes[kBatchBytes];
    ssize_t count = 0;
    do {
      count = read(socket_, bytes, sizeof bytes);
    } while (count == ssize_t(sizeof bytes));
    return count > 0 || (count < 0 && errno == EAGAIN);
  }

  /// Waits, up to a limit, until the socket is writable.
  void Await() const {
    pollfd wanted{socket_, POLLOUT | POLLIN, 0};
    poll(&wanted, 1, 10);
  }

 private:
  int socket_;
};

struct Wanted {
  std::string mode;
  int port;
  double rate;
  double end;  ///< End of the flood [s].
  std::string body;
};

/// Returns the hello of an agent in that body, or of an observer if `body` is empty.
std::string Hello(uint64_t times, const std::string& body) {
  return "{\"t\":\"hello\",\"protocol\":1,\"name\":\"flood-" + std::to_string(times) + "\"," +
         (body.empty() ? "\"role\":\"observer\"" : "\"body\":\"" + body + "\"") + "}\n";
}

/// Counts messages and limits their rate.
struct Pace {
  double rate;  ///< Messages per second.
  double begun = Now();
  uint64_t done = 0;

  bool Ahead() const { return double(done) > (Now() - begun) * rate; }
  void Wait() const {
    while (Ahead()) std::this_thread::sleep_for(std::chrono::duration<double>(kPauseSeconds));
  }
};

/// Results of a flood.
struct Flood {
  uint64_t done = 0;
  uint64_t connections = 0;
};

Flood Connects(const Wanted& wanted) {
  Pace pace{wanted.rate};
  std::deque<Connection> open;
  for (; Now() < wanted.end; pace.done++) {
    pace.Wait();
    open.emplace_back(wanted.port);
    if (wanted.mode == "logins") {
      const std::string hello = Hello(pace.done, "");
      open.back().Write(hello.data(), hello.size());
    } else if (pace.done % 2 == 0) {
      open.pop_back();
    }
    if (open.size() > kLeftOpen) open.pop_front();
  }
  return {pace.done, pace.done};
}

std::string Message(const Wanted& wanted, uint64_t id) {
  if (wanted.mode == "pings") return "{\"t\":\"ping\"}\n";
  return "{\"t\":\"act\",\"id\":" + std::to_string(id) + ",\"item\":\"p" + wanted.body.substr(1) +
         "\",\"action\":\"push\",\"arguments\":{\"impulse\":[0,0,1]}}\n";
}

/// Sends one agent's messages until the server disconnects it, or the time is over.
void Send(const Connection& connection, const Wanted& wanted, Pace& pace) {
  std::string batch;
  uint64_t id = 0;
  while (Now() < wanted.end) {
    pace.Wait();
    uint64_t messages = 0;
    for (; batch.size() < kBatchBytes; messages++) batch += Message(wanted, id++);
    for (size_t sent = 0; sent < batch.size() && Now() < wanted.end;) {
      const ssize_t count = connection.Write(batch.data() + sent, batch.size() - sent);
      if (count < 0 || !connection.Drain()) return;
      if (count == 0) connection.Await();
      sent += size_t(count);
      pace.done += messages * size_t(count) / batch.size();
    }
    batch.clear();
  }
}

Flood Messages(const Wanted& wanted) {
  Pace pace{wanted.rate};
  uint64_t connections = 0;
  for (; Now() < wanted.end; connections++) {
    const Connection connection(wanted.port);
    const std::string hello = Hello(connections, wanted.body);
    connection.Write(hello.data(), hello.size());
    connection.DoNotBlock();
    Send(connection, wanted, pace);
  }
  return {pace.done, connections};
}

void Sink(int port) {
  const int listening = socket(AF_INET, SOCK_STREAM, 0);
  const int on = 1;
  setsockopt(listening, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  const sockaddr_in address = Loopback(port);
  if (bind(listening, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      listen(listening, 512) != 0) {
    Fail("cannot listen on port " + std::to_string(port));
  }
  const int epoll = epoll_create1(0);
  const auto add = [epoll](int socket) {
    epoll_event event{EPOLLIN, {.fd = socket}};
    epoll_ctl(epoll, EPOLL_CTL_ADD, socket, &event);
  };
  add(listening);
  static char bytes[kBatchBytes];
  while (true) {
    epoll_event ready[64];
    const int count = epoll_wait(epoll, ready, 64, -1);
    for (int i = 0; i < count; i++) {
      const int socket = ready[i].data.fd;
      if (socket == listening) {
        add(accept4(listening, nullptr, nullptr, SOCK_NONBLOCK));
      } else if (read(socket, bytes, sizeof bytes) <= 0) {
        close(socket);
      } else {
        send(socket, "{\"t\":\"pong\"}\n", 13, MSG_NOSIGNAL | MSG_DONTWAIT);
      }
    }
  }
}

double ProcessorSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](timeval t) { return double(t.tv_sec) + double(t.tv_usec) * 1e-6; };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

}  // namespace

int main(int count, char** arguments) {
  try {
    const std::string mode = count > 1 ? arguments[1] : "";
    if (mode == "sink" && count == 3) Sink(std::stoi(arguments[2]));
    if (count != 6) throw std::invalid_argument("usage: flood MODE PORT RATE SECONDS BODY");
    const double begun = Now();
    const Wanted wanted{mode, std::stoi(arguments[2]), std::stod(arguments[3]),
                        begun + std::stod(arguments[4]), arguments[5]};
    const bool talks = mode == "pings" || mode == "acts";
    const Flood flood = talks ? Messages(wanted) : Connects(wanted);
    const double seconds = Now() - begun;
    std::printf("{\"perSecond\":%.0f,\"connections\":%llu,\"processors\":%.3f}\n",
                double(flood.done) / seconds, static_cast<unsigned long long>(flood.connections),
                ProcessorSeconds() / seconds);
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "flood: %s\n", e.what());
    return 1;
  }
}

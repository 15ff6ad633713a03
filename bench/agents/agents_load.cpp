// SPDX-License-Identifier: Apache-2.0
// Many clients of a server on loopback, in one thread; see docs/benchmarks.md.
//
//   agents_load echo      PORT CLIENTS SECONDS BYTES
//   agents_load lock-step PORT CLIENTS SECONDS json|msgpack
//   agents_load stream    PORT CLIENTS SECONDS json|msgpack
//   agents_load deaf      PORT CLIENTS 0       json|msgpack
//
// Client n has the name a<n>, requests the body a<n>, and pushes the item p<n>. CLIENTS is the
// number of clients, or FIRST+COUNT. Prints one JSON object, except in mode deaf: these clients
// only send requests, never read, and stay until the program's standard input ends.

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <sys/epoll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace {

constexpr double kWarmUpSeconds = 1.5;
constexpr double kSliceSeconds = 0.5;
constexpr double kFrameSeconds = 1.0 / 60;
constexpr size_t kReadBytes = 1 << 16;

using Bytes = std::string;

double Now() {
  using std::chrono::steady_clock;
  return std::chrono::duration<double>(steady_clock::now().time_since_epoch()).count();
}

[[noreturn]] void Fail(const std::string& what) {
  throw std::runtime_error(what + (errno != 0 ? ": " + std::string(std::strerror(errno)) : ""));
}

// The functions below encode the messages of clients in MessagePack. They support only texts of up
// to 31 bytes and small numbers.
Bytes Text(std::string_view text) { return char(0xa0 | text.size()) + Bytes(text); }

Bytes Number(uint64_t number) {
  Bytes bytes(1, char(0xcf));
  for (int shift = 56; shift >= 0; shift -= 8) bytes += char(number >> shift);
  return bytes;
}

Bytes Framed(const Bytes& message) {
  Bytes bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += char(message.size() >> shift);
  return bytes + message;
}

/// One client, with the received part of an incomplete message.
class Client {
 public:
  Client(int id, int port, bool packed, int receive_bytes) : id_(id), packed_(packed) {
    socket_ = ::socket(AF_INET, SOCK_STREAM, 0);
    const int on = 1;
    setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    if (receive_bytes > 0) {
      setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &receive_bytes, sizeof receive_bytes);
    }
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    errno = 0;
    if (connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0) {
      Fail("client " + std::to_string(id) + " cannot connect to port " + std::to_string(port));
    }
  }

  int Socket() const { return socket_; }

  void Send(const Bytes& bytes) const {
    errno = 0;
    if (write(socket_, bytes.data(), bytes.size()) != ssize_t(bytes.size())) {
      Fail("client " + std::to_string(id_) + " cannot write");
    }
  }

  /// Joins a world without a body.
  void Observe() const {
    Send("{\"t\":\"hello\",\"protocol\":1,\"name\":\"o" + std::to_string(id_) +
         "\",\"role\":\"observer\",\"encoding\":\"" + (packed_ ? "msgpack" : "json") + "\"}\n");
  }

  void Hello(bool lock_step) const {
    const std::string name = "a" + std::to_string(id_);
    Send("{\"t\":\"hello\",\"protocol\":1,\"name\":\"" + name + "\",\"body\":\"" + name +
         "\",\"encoding\":\"" + (packed_ ? "msgpack" : "json") + "\"" +
         (lock_step ? ",\"time\":{\"mode\":\"lock-step\"}" : "") + "}\n");
  }

  /// @param every interval between two perceptions [frames], below 128
  void Perceive(int every) const {
    Send(packed_ ? Framed("\x82" + Text("t") + Text("perceive") + Text("every") + char(every))
                 : "{\"t\":\"perceive\",\"every\":" + std::to_string(every) + "}\n");
  }

  /// Sends the act that pushes the client's item, and ends the client's part of the frame.
  void Act() {
    const std::string item = "p" + std::to_string(id_);
    acts_++;
    if (packed_) {
      Send(Framed("\x86" + Text("t") + Text("act") + Text("id") + Number(acts_) + Text("item") +
                  Text(item) + Text("action") + Text("push") + Text("arguments") + "\x81" +
                  Text("impulse") + Bytes("\x93\x00\x00\x01", 4) + Text("ready") + "\xc3"));
    } else {
      Send("{\"t\":\"act\",\"id\":" + std::to_string(acts_) + ",\"item\":\"" + item +
           "\",\"action\":\"push\",\"arguments\":{\"impulse\":[0,0,1]},\"ready\":true}\n");
    }
  }

  /// Reads available bytes, and waits if there are none. Returns the number of bytes read.
  size_t Read() {
    char bytes[kReadBytes];
    errno = 0;
    const ssize_t count = read(socket_, bytes, sizeof bytes);
    if (count <= 0) {
      Fail("client " + std::to_string(id_) + " was cut off; it had got: " + pending_);
    }
    pending_.append(bytes, size_t(count));
    return size_t(count);
  }

  /// Removes complete messages from the input. Returns the number of perceptions among them.
  int TakePerceptions() {
    int perceptions = 0;
    size_t begin = 0;
    for (std::string_view message = Next(begin); !message.empty(); message = Next(begin)) {
      if (Is(message, "perception")) {
        perceptions++;
        world_time = WorldTime(message);
      } else if (Is(message, "bye") || Is(message, "error") ||
                 message.find("\"accepted\":false") != std::string_view::npos) {
        errno = 0;
        Fail("client " + std::to_string(id_) + " was told: " + std::string(message));
      }
    }
    pending_.erase(0, begin);
    return perceptions;
  }

  /// Discards bytes. Returns true when this number of bytes has arrived.
  bool TakeEcho(size_t bytes) {
    if (pending_.size() < bytes) return false;
    pending_.clear();
    return true;
  }

  double since = 0;       ///< Time of the last send or, for a stream, of the last perception [s].
  double world_time = 0;  ///< World time of the last perception [s].

 private:
  std::string_view Next(size_t& begin) const {
    const std::string_view rest = std::string_view(pending_).substr(begin);
    size_t size = 0;
    if (!rest.empty() && (!packed_ || rest[0] == '{')) {
      size = rest.find('\n') + 1;
    } else if (rest.size() >= 4) {
      for (int i = 0; i < 4; i++) size = size << 8 | uint8_t(rest[size_t(i)]);
      size += 4;
    }
    if (size == 0 || size > rest.size()) return {};
    begin += size;
    return rest.substr(0, size);
  }

  /// Returns true if the message of the server has this type.
  bool Is(std::string_view message, std::string_view type) const {
    return message[0] == '{' ? message.substr(6, type.size()) == type
                             : message.substr(8, type.size()) == type;
  }

  /// Returns the value after the first key `time`: a number in JSON, or a 64-bit float in
  /// MessagePack.
  double WorldTime(std::string_view message) const {
    const char* key = message.data() + message.find("time") + 4;
    if (!packed_) return std::strtod(key + 2, nullptr);
    uint64_t bits = 0;
    for (int i = 1; i <= 8; i++) bits = bits << 8 | uint8_t(key[i]);
    return std::bit_cast<double>(bits);
  }

  int id_;
  int socket_;
  bool packed_;
  uint64_t acts_ = 0;
  std::string pending_;
};

struct Wanted {
  std::string mode;
  int port;
  int first;
  int clients;
  double seconds;
  std::string how;
  int every;
};

class Load {
 public:
  explicit Load(const Wanted& wanted) : wanted_(wanted) {
    const bool packed = wanted.how == "msgpack";
    clients_.reserve(size_t(wanted.clients));
    for (int i = 0; i < wanted.clients; i++) {
      clients_.emplace_back(wanted.first + i, wanted.port, packed,
                            wanted.mode == "deaf" ? 4096 : 0);
      if (wanted.mode == "observe") {
        clients_.back().Observe();
        clients_.back().Perceive(wanted.every);
      } else if (wanted.mode != "echo") {
        clients_.back().Hello(wanted.mode == "lock-step");
        if (wanted.mode != "lock-step") clients_.back().Perceive(wanted.every);
      }
    }
    if (wanted.mode == "echo") echo_ = Bytes(std::stoul(wanted.how), 'x');
  }

  void Run() {
    if (wanted_.mode == "deaf") {
      while (std::getchar() != EOF) {
      }
      return;
    }
    if (wanted_.mode == "echo") {
      for (Client& client : clients_) Begin(client, Now());
    }
    const double begin = Now() + kWarmUpSeconds;
    const double end = begin + wanted_.seconds;
    double cpu = 0;
    double now = Now();
    slice_begun_ = now;
    for (bool counting = false; now < end; now = Now()) {
      if (now - slice_begun_ >= kSliceSeconds) EndSlice(now);
      if (!counting && now >= begin) {
        counting = true;
        samples_.clear();
        behind_.clear();
        bytes_ = 0;
        begun_ = now;
        cpu = ProcessorSeconds();
      }
      clients_.size() == 1 ? Serve(clients_.front()) : ServeReady();
    }
    Report(now - begun_, ProcessorSeconds() - cpu);
  }

 private:
  void EndSlice(double now) {
    slices_.push_back(double(slice_count_) / (now - slice_begun_));
    slice_begun_ = now;
    slice_count_ = 0;
  }

  void Begin(Client& client, double now) {
    client.since = now;
    echo_.empty() ? client.Act() : client.Send(echo_);
  }

  void Serve(Client& client) {
    bytes_ += client.Read();
    const double now = Now();
    const int whole = echo_.empty() ? client.TakePerceptions() : client.TakeEcho(echo_.size());
    if (whole == 0) return;
    slice_count_++;
    const double sample = now - client.since;
    if (client.since > 0) samples_.push_back(float(sample));
    if (wanted_.mode == "stream" || wanted_.mode == "observe") {
      client.since = now;
      behind_.push_back(now - client.world_time);
    } else {
      Begin(client, now);
    }
  }

  void ServeReady() {
    if (epoll_ < 0) {
      epoll_ = epoll_create1(0);
      for (size_t i = 0; i < clients_.size(); i++) {
        epoll_event event{EPOLLIN, {.u64 = i}};
        epoll_ctl(epoll_, EPOLL_CTL_ADD, clients_[i].Socket(), &event);
      }
    }
    epoll_event ready[256];
    const int count = epoll_wait(epoll_, ready, 256, 1000);
    for (int i = 0; i < count; i++) Serve(clients_[ready[i].data.u64]);
  }

  static double ProcessorSeconds() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](timeval t) { return double(t.tv_sec) + double(t.tv_usec) * 1e-6; };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
  }

  template <class Number>
  static double Quantile(std::vector<Number>& samples, double share) {
    const auto place = samples.begin() + ptrdiff_t(share * double(samples.size() - 1));
    std::nth_element(samples.begin(), place, samples.end());
    return *place;
  }

  void Report(double seconds, double cpu) {
    if (samples_.empty()) throw std::runtime_error("nothing was perceived");
    const double rate = double(samples_.size()) / seconds;
    const double clients = double(clients_.size());
    double median = Quantile(samples_, 0.5) * 1e6;
    double p99 = Quantile(samples_, 0.99) * 1e6;
    double late_p99 = 0;
    if (wanted_.mode == "stream") {  // deviation from the frame interval
      for (float& sample : samples_) sample = float(std::abs(double(sample) - kFrameSeconds));
      median = Quantile(samples_, 0.5) * 1e6;
      p99 = Quantile(samples_, 0.99) * 1e6;
      late_p99 = (Quantile(behind_, 0.99) - Quantile(behind_, 0)) * 1e6;
    }
    std::printf(
        "{\"perSecond\":%.1f,\"medianMicros\":%.1f,\"p99Micros\":%.1f,"
        "\"lateP99Micros\":%.1f,\"bytesPerClientSecond\":%.0f,"
        "\"clientProcessors\":%.3f,\"slices\":[",
        rate, median, p99, late_p99, double(bytes_) / seconds / clients, cpu / seconds);
    const char* separator = "";
    for (const double slice : slices_) {
      std::printf("%s%.0f", separator, slice);
      separator = ",";
    }
    std::printf("]}\n");
  }

  Wanted wanted_;
  std::vector<Client> clients_;
  Bytes echo_;
  std::vector<float> samples_;
  std::vector<double> behind_;  ///< For each perception of a stream: clock minus world time [s].
  uint64_t bytes_ = 0;
  double begun_ = 0;
  std::vector<double> slices_;  ///< Rate of samples [1/s] in each half second since the beginning.
  double slice_begun_ = 0;
  uint64_t slice_count_ = 0;
  int epoll_ = -1;
};

}  // namespace

int main(int count, char** arguments) {
  try {
    if (count < 6 || count > 7) {
      throw std::invalid_argument(
          "usage: agents_load MODE PORT CLIENTS SECONDS BYTES|ENCODING [FRAMES]");
    }
    const std::string clients = arguments[3];
    const size_t plus = clients.find('+');
    const int first = plus == std::string::npos ? 0 : std::stoi(clients);
    Load({arguments[1], std::stoi(arguments[2]), first,
          std::stoi(plus == std::string::npos ? clients : clients.substr(plus + 1)),
          std::stod(arguments[4]), arguments[5], count == 7 ? std::stoi(arguments[6]) : 1})
        .Run();
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "agents_load: %s\n", e.what());
    return 1;
  }
}

// SPDX-License-Identifier: Apache-2.0
// An echo server with one thread that waits with epoll; measures the cost of the kernel alone.
//   echo_epoll PORT
#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <stdlib.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

int main(int count, char** arguments) {
  if (count != 2) return 2;
  const int on = 1;
  const int listening = socket(AF_INET, SOCK_STREAM, 0);
  setsockopt(listening, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  struct sockaddr_in address = {.sin_family = AF_INET,
                                .sin_port = htons((unsigned short)atoi(arguments[1])),
                                .sin_addr = {htonl(INADDR_LOOPBACK)}};
  if (bind(listening, (void*)&address, sizeof address) != 0) return 1;
  if (listen(listening, 2048) != 0) return 1;
  const int epoll = epoll_create1(0);
  struct epoll_event event = {.events = EPOLLIN, .data = {.fd = listening}};
  epoll_ctl(epoll, EPOLL_CTL_ADD, listening, &event);
  static char buffer[65536];
  for (;;) {
    struct epoll_event ready[256];
    const int events = epoll_wait(epoll, ready, 256, -1);
    for (int i = 0; i < events; i++) {
      const int from = ready[i].data.fd;
      if (from == listening) {
        event.data.fd = accept(listening, 0, 0);
        setsockopt(event.data.fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
        epoll_ctl(epoll, EPOLL_CTL_ADD, event.data.fd, &event);
        continue;
      }
      const ssize_t bytes = read(from, buffer, sizeof buffer);
      if (bytes <= 0 || write(from, buffer, (size_t)bytes) < 0) close(from);
    }
  }
}

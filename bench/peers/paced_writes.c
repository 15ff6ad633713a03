// SPDX-License-Identifier: Apache-2.0
// Writes a message of fixed size to each client sixty times per second. The size is that of an
// update of five moving items in MessagePack. The program makes no world and reads nothing, so it
// measures the jitter of the machine alone.
//   paced_writes PORT
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <errno.h>
#include <netinet/tcp.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum { kMessageBytes = 328, kMaxClients = 4096, kSecond = 1000000000 };

static const char kBegin[] = {0,
                              0,
                              (kMessageBytes - 4) >> 8,
                              (char)((kMessageBytes - 4) & 255),
                              (char)0x84,
                              (char)0xa1,
                              't',
                              (char)0xaa,
                              'p',
                              'e',
                              'r',
                              'c',
                              'e',
                              'p',
                              't',
                              'i',
                              'o',
                              'n'};

static long long Now(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * (long long)kSecond + now.tv_nsec;
}

int main(int count, char** arguments) {
  if (count != 2) return 2;
  signal(SIGPIPE, SIG_IGN);
  const int on = 1;
  const int listening = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0);
  setsockopt(listening, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  struct sockaddr_in address = {.sin_family = AF_INET,
                                .sin_port = htons((unsigned short)atoi(arguments[1])),
                                .sin_addr = {htonl(INADDR_LOOPBACK)}};
  if (bind(listening, (void*)&address, sizeof address) != 0) return 1;
  if (listen(listening, 2048) != 0) return 1;
  static int clients[kMaxClients];
  int open = 0;
  char message[kMessageBytes] = {0};
  memcpy(message, kBegin, sizeof kBegin);
  for (long long due = Now();; due += kSecond / 60) {
    if (Now() - due > kSecond) due = Now();  // the process was stopped
    const struct timespec until = {due / kSecond, due % kSecond};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL);
    while (open < kMaxClients) {
      const int client = accept4(listening, 0, 0, SOCK_NONBLOCK);
      if (client < 0) break;
      setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
      clients[open++] = client;
    }
    for (int i = open - 1; i >= 0; i--) {
      if (write(clients[i], message, sizeof message) < 0 && errno != EAGAIN) {
        close(clients[i]);
        clients[i] = clients[--open];
      }
    }
  }
}

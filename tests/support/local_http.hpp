// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <string>

namespace vdrive::test {

/// @return a connection to a port of this host, or -1.
inline int connected(int port) {
  const int connection = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  inet_pton(AF_INET, "127.0.0.1", &address.sin_addr);
  // NOLINTNEXTLINE(*-reinterpret-cast): what the socket interface takes
  if (connect(connection, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0) {
    return connection;
  }
  close(connection);
  return -1;
}

/// @return the answer to an HTTP request, including its head; empty if there is none.
inline std::string answer_to(int port, const std::string& request) {
  const int connection = connected(port);
  (void)send(connection, request.data(), request.size(), MSG_NOSIGNAL);
  std::string answer;
  std::array<char, 4096> part{};
  for (ssize_t got = recv(connection, part.data(), part.size(), 0); got > 0;
       got = recv(connection, part.data(), part.size(), 0)) {
    answer.append(part.data(), static_cast<std::size_t>(got));
  }
  close(connection);
  return answer;
}

inline std::string http_get(int port, const std::string& path) {
  return answer_to(port, "GET " + path + " HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n");
}

}  // namespace vdrive::test

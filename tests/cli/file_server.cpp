#include "cli/file_server.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <regex>
#include <stdexcept>

#include "cli/program.h"

namespace mq::test {
namespace {

constexpr int step = 50;  // milliseconds, after which it is asked whether the server is over

bool has_input(int descriptor) {
  pollfd wait{descriptor, POLLIN, 0};
  return poll(&wait, 1, step) > 0;
}

void send_all(int connection, const std::string& text) {
  for (std::size_t sent = 0; sent < text.size();) {
    const ssize_t count = send(connection, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
    if (count <= 0) return;
    sent += std::size_t(count);
  }
}

std::string type_of(const std::filesystem::path& path) {
  if (path.extension() == ".html") return "text/html";
  if (path.extension() == ".webm") return "video/webm";
  return path.extension() == ".mp4" ? "video/mp4" : "application/octet-stream";
}

}  // namespace

FileServer::FileServer(std::filesystem::path folder, Ranges ranges) : folder_(std::move(folder)), ranges_(ranges) {
  listening_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof place;
  if (bind(listening_, reinterpret_cast<sockaddr*>(&place), size) != 0 || listen(listening_, 16) != 0 ||
      getsockname(listening_, reinterpret_cast<sockaddr*>(&place), &size) != 0)
    throw std::runtime_error("no port can be had");
  port_ = ntohs(place.sin_port);
  thread_ = std::thread([this] { accept_all(); });
}

FileServer::~FileServer() {
  is_over_ = true;
  thread_.join();
  for (std::thread& answer : answers_) answer.join();
  close(listening_);
}

std::string FileServer::address() const { return fmt::format("http://127.0.0.1:{}/", port_); }

std::vector<std::string> FileServer::requests() const {
  const std::lock_guard lock(mutex_);
  return requests_;
}

void FileServer::accept_all() {
  while (!is_over_) {
    if (!has_input(listening_)) continue;
    const int connection = accept4(listening_, nullptr, nullptr, SOCK_CLOEXEC);
    if (connection >= 0) answers_.emplace_back([this, connection] { serve(connection); });
  }
}

void FileServer::serve(int connection) {
  std::string request;
  char bytes[4096];
  while (!is_over_ && request.find("\r\n\r\n") == std::string::npos) {
    if (!has_input(connection)) continue;
    const ssize_t count = read(connection, bytes, sizeof bytes);
    if (count <= 0) break;
    request.append(bytes, std::size_t(count));
  }
  std::smatch found, range;
  if (std::regex_search(request, found, std::regex("^GET /([^ ?]*)"))) {
    const std::string name = found[1];
    const bool has_range = std::regex_search(request, range, std::regex("[Rr]ange: bytes=([0-9]+)-([0-9]*)"));
    {
      const std::lock_guard lock(mutex_);
      requests_.push_back(has_range ? fmt::format("{} {}-{}", name, range[1].str(), range[2].str()) : name);
    }
    if (!std::filesystem::is_regular_file(folder_ / name)) {
      send_all(connection, "HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n");
    } else {
      std::string body = file_bytes(folder_ / name), status = "200 OK", more;
      if (has_range && ranges_ == Ranges::sent) {
        const std::size_t all = body.size(), first = std::stoull(range[1]);
        const std::size_t last = range[2].length() == 0 ? all - 1 : std::min<std::size_t>(std::stoull(range[2]), all - 1);
        body = body.substr(first, last + 1 - first);
        status = "206 Partial Content";
        more = fmt::format("Content-Range: bytes {}-{}/{}\r\n", first, last, all);
      }
      send_all(connection, fmt::format("HTTP/1.1 {}\r\nContent-Type: {}\r\nContent-Length: {}\r\n{}Connection: "
                                       "close\r\n\r\n",
                                       status, type_of(name), body.size(), more) +
                               body);
    }
  }
  close(connection);
}

}  // namespace mq::test

#pragma once
/// Files of a folder for a browser, by HTTP, on this machine alone.

#include <atomic>
#include <filesystem>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace mq::test {

class FileServer {
 public:
  enum class Ranges { sent, ignored };  ///< ignored: whole files are sent in their place

  /// Throws `std::runtime_error` where no port can be had.
  FileServer(std::filesystem::path folder, Ranges ranges);
  ~FileServer();
  FileServer(const FileServer&) = delete;
  FileServer& operator=(const FileServer&) = delete;

  std::string address() const;  ///< http://127.0.0.1:PORT/

  /// What was asked for: "NAME", or "NAME FIRST-LAST" of a range.
  std::vector<std::string> requests() const;

 private:
  void accept_all();
  void serve(int connection);

  std::filesystem::path folder_;
  Ranges ranges_;
  int listening_ = -1, port_ = 0;
  std::atomic<bool> is_over_ = false;
  mutable std::mutex mutex_;
  std::vector<std::string> requests_;
  std::vector<std::thread> answers_;
  std::thread thread_;
};

}  // namespace mq::test

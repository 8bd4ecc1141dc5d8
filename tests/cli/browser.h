#pragma once
/// A browser without a window (Chromium), driven over its debugging pipe.

#include <sys/types.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

namespace mq::test {

class Browser {
 public:
  /// Whether there is one on this machine.
  static bool installed();

  /// `profile` is a folder for what it wants to keep. Throws `std::runtime_error`, as all here do,
  /// where the browser ends or says nothing for two minutes.
  explicit Browser(const std::filesystem::path& profile);
  ~Browser();
  Browser(const Browser&) = delete;
  Browser& operator=(const Browser&) = delete;

  void open(const std::string& address);

  /// The value of a JavaScript expression, waited for where it is a promise.
  nlohmann::json evaluate(const std::string& expression);

  /// Waits until the expression is true, and throws nothing; false after a minute.
  bool becomes_true(const std::string& expression);

  /// What is shown, as a PNG file.
  void screenshot(const std::filesystem::path& path);

 private:
  nlohmann::json call(const std::string& method, const nlohmann::json& parameters);
  nlohmann::json receive();

  pid_t process_ = -1;
  int to_ = -1, from_ = -1;
  int last_call_ = 0;
  std::string session_, received_;
};

}  // namespace mq::test

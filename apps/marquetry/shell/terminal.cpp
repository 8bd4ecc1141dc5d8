#include "shell/terminal.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>

#include "shell/duration.h"

namespace mq::app {
namespace {

constexpr double seconds_before_first = 1;  ///< quicker work shows no progress
constexpr double seconds_between_bars = 0.1;
constexpr double seconds_between_lines = 5;
constexpr double seconds_between_steps = 0.25;  ///< shorter steps are not told of when they begin

const char* const yellow = "\033[33m";
const char* const red = "\033[31m";

double seconds_between(auto from, auto to) {
  return std::chrono::duration<double>(to - from).count();
}

bool environment_has(const char* name) {
  const char* value = std::getenv(name);
  return value && *value;
}

int terminal_width() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 20 ? size.ws_col : 80;
}

void print_line(const nlohmann::ordered_json& object) {
  fmt::print(stderr, "{}\n", object.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

/// Without characters that do something to a terminal, which a file's name may have. Lists go on below.
std::string harmless(std::string text) {
  for (char& c : text)
    if (c != '\n' && (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)) c = '?';
  return replaced(std::move(text), "\n", "\n  ");
}

/// Of "frame 3 / solve / factorisation" the frame and the last.
std::string shown_step(const std::string& path) {
  static constexpr std::string_view between = " / ";
  const std::size_t first = path.find(between), last = path.rfind(between);
  if (last == std::string::npos) return path;
  const std::string innermost = path.substr(last + between.size());
  return path.starts_with("frame ") ? path.substr(0, first) + ", " + innermost : innermost;
}

}  // namespace

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

Terminal::Terminal(const std::string& verb, const std::string& program)
    : prefix_(verb.empty() ? program + ": " : program + " " + verb + ": "),
      is_terminal_(isatty(STDERR_FILENO) != 0),
      colored_(is_terminal_ && !environment_has("NO_COLOR")) {}

Terminal::~Terminal() { erase_bar(); }

std::string Terminal::step() {
  const std::lock_guard lock(mutex_);
  return shown_step(path_);
}

void Terminal::progress(const ProgressEvent& event) {
  const std::lock_guard lock(mutex_);
  const bool begins = path_ != event.step;
  if (begins) path_ = event.step;
  detail_ = event.detail.empty() ? "" : ", " + event.detail;
  fraction_ = event.fraction;
  if (voice_ == Voice::quiet) return;
  const auto now = Clock::now();
  const double elapsed = seconds_between(start_, now);
  const double pause = seconds_between(last_, now);
  if (form_ == Form::json) {
    if (last_ != start_ && pause < seconds_between_bars) return;
    last_ = now;
    return progress_line(event.fraction, elapsed);
  }
  const double wanted = is_terminal_ && bar_shown_        ? seconds_between_bars
                        : is_terminal_ || last_ == start_ ? seconds_before_first
                        : begins                          ? seconds_between_steps
                                                          : seconds_between_lines;
  if (elapsed < seconds_before_first || pause < wanted) return;
  last_ = now;
  if (is_terminal_)
    draw_bar(event.fraction, elapsed);
  else
    fmt::print(stderr, "{}{:3.0f} % {}{}\n", prefix_, 100 * event.fraction, shown_step(path_) + detail_,
               estimate(left_.seconds(event.fraction, elapsed)));
}

void Terminal::foresee(double seconds) {
  const std::lock_guard lock(mutex_);
  left_.foresee(fraction_, seconds_between(start_, Clock::now()), seconds);
}

void Terminal::progress_line(double fraction, double elapsed) {
  const std::optional<double> left = left_.seconds(fraction, elapsed);
  print_line({{"event", "progress"},
              {"fraction", fraction},
              {"step", path_},
              {"detail", detail_.empty() ? "" : detail_.substr(2)},
              {"elapsed", elapsed},
              {"left", left ? nlohmann::ordered_json(*left) : nlohmann::ordered_json()}});
}

void Terminal::draw_bar(double fraction, double elapsed) {
  constexpr int bar_width = 24;
  const int filled = int(fraction * bar_width);
  std::string text =
      fmt::format("[{:=>{}}{:>{}}] {:3.0f} %{}  {}", "", filled, "", bar_width - filled,
                  100 * fraction, estimate(left_.seconds(fraction, elapsed)), shown_step(path_) + detail_);
  if (int(text.size()) >= terminal_width()) text.resize(std::size_t(terminal_width() - 1));
  fmt::print(stderr, "\r\033[K{}", text);
  std::fflush(stderr);
  bar_shown_ = true;
}

void Terminal::erase_bar() {
  if (!bar_shown_) return;
  fmt::print(stderr, "\r\033[K");
  std::fflush(stderr);
  bar_shown_ = false;
}

void Terminal::line(const char* color, const std::string& message) {
  const std::lock_guard lock(mutex_);
  const std::string text = harmless(part_.empty() ? message : part_ + ": " + message);
  erase_bar();
  if (colored_ && color)
    fmt::print(stderr, "{}{}{}\033[0m\n", color, prefix_, text);
  else
    fmt::print(stderr, "{}{}\n", prefix_, text);
}

void Terminal::rename(const std::string& file, const std::string& name) { names_.emplace_back(file, name); }

std::string Terminal::renamed(std::string text) const {
  for (const auto& [file, name] : names_) text = replaced(std::move(text), file, name);
  return text;
}

void Terminal::set_part(const std::string& part) {
  const std::lock_guard lock(mutex_);
  part_ = part;
}

void Terminal::say(const char* event, const char* color, const std::string& said) {
  std::string text = renamed(said);
  if (form_ == Form::json) {
    const std::lock_guard lock(mutex_);
    nlohmann::ordered_json object = {{"event", event}, {"text", text}};
    if (!part_.empty()) object["part"] = part_;
    return print_line(object);
  }
  if (std::string_view(event) == "warning") text = "warning: " + text;
  line(color, text);
}

void Terminal::point_to_check(const std::string& file) {
  if (to_check_.empty() && renamed(file) == file) to_check_ = file;
}

void Terminal::say_where_more_is() {
  if (!to_check_.empty()) remark("'marquetry check " + to_check_ + "' tells more of these warnings");
  to_check_.clear();
}

void Terminal::set_listener(Listener listener) {
  const std::lock_guard lock(listener_mutex_);
  listener_ = std::move(listener);
}

void Terminal::tell(const std::string& text) {
  const std::lock_guard lock(listener_mutex_);
  if (listener_) listener_(text);
}

void Terminal::remark(const std::string& text) {
  tell(text);
  if (voice_ == Voice::normal) say("remark", nullptr, text);
}

void Terminal::warning(const std::string& text) {
  tell(text);
  if (voice_ == Voice::normal) say("warning", yellow, text);
}

void Terminal::safe(const std::string& text) {
  const std::lock_guard lock(safe_mutex_);
  safe_ = text;
}

std::string Terminal::what_is_safe() {
  const std::lock_guard lock(safe_mutex_);
  return safe_;
}

void Terminal::error(const std::string& text) { say("error", red, text); }

}  // namespace mq::app

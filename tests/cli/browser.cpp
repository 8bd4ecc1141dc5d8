#include "cli/browser.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <stdexcept>
#include <thread>

#include "cli/program.h"
#include "mq/io/uri.h"

namespace mq::test {
namespace {

using Json = nlohmann::json;
constexpr int patience = 120'000;  // milliseconds

/// In the child: the pipe's ends become descriptors 3 and 4, as the browser wants them.
[[noreturn]] void become_browser(int read_end, int write_end, const std::string& profile) {
  const int in = fcntl(read_end, F_DUPFD, 10), out = fcntl(write_end, F_DUPFD, 10);
  dup2(in, 3);
  dup2(out, 4);
  const int nothing = ::open("/dev/null", O_RDWR);
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(nothing, standard);
  setpgid(0, 0);
  const std::string folder = "--user-data-dir=" + profile;
  execlp("chromium", "chromium", "--headless=new", "--no-sandbox", "--use-angle=swiftshader",
         "--enable-unsafe-swiftshader", "--remote-debugging-pipe", "--window-size=800,500",
         folder.c_str(), "about:blank", nullptr);
  _exit(127);
}

}  // namespace

bool Browser::installed() { return std::system("command -v chromium > /dev/null") == 0; }

Browser::Browser(const std::filesystem::path& profile) {
  signal(SIGPIPE, SIG_IGN);
  int there[2], back[2];
  if (pipe2(there, O_CLOEXEC) != 0 || pipe2(back, O_CLOEXEC) != 0)
    throw std::runtime_error("no pipe can be made");
  process_ = fork();
  if (process_ == 0) become_browser(there[0], back[1], profile.string());
  close(there[0]);
  close(back[1]);
  to_ = there[1];
  from_ = back[0];
  const Json page = call("Target.createTarget", {{"url", "about:blank"}})["targetId"];
  session_ = call("Target.attachToTarget", {{"targetId", page}, {"flatten", true}})["sessionId"];
}

Browser::~Browser() {
  kill(-process_, SIGKILL);
  waitpid(process_, nullptr, 0);
  close(to_);
  close(from_);
}

Json Browser::receive() {
  for (;;) {
    if (const std::size_t end = received_.find('\0'); end != std::string::npos) {
      const Json message = Json::parse(received_.substr(0, end));
      received_.erase(0, end + 1);
      return message;
    }
    pollfd wait{from_, POLLIN, 0};
    if (poll(&wait, 1, patience) <= 0) throw std::runtime_error("the browser says nothing");
    char bytes[65536];
    const ssize_t count = read(from_, bytes, sizeof bytes);
    if (count <= 0) throw std::runtime_error("the browser has ended");
    received_.append(bytes, std::size_t(count));
  }
}

Json Browser::call(const std::string& method, const Json& parameters) {
  Json message{{"id", ++last_call_}, {"method", method}, {"params", parameters}};
  if (!session_.empty()) message["sessionId"] = session_;
  const std::string text = message.dump() + '\0';
  for (std::size_t sent = 0; sent < text.size();) {
    const ssize_t count = write(to_, text.data() + sent, text.size() - sent);
    if (count <= 0) throw std::runtime_error("the browser has ended");
    sent += std::size_t(count);
  }
  for (;;) {
    const Json answer = receive();
    if (answer.value("id", 0) != last_call_) continue;  // an event
    if (answer.contains("error")) throw std::runtime_error(method + ": " + answer["error"].dump());
    return answer["result"];
  }
}

void Browser::open(const std::string& address) { call("Page.navigate", {{"url", address}}); }

Json Browser::evaluate(const std::string& expression) {
  const Json answer =
      call("Runtime.evaluate",
           {{"expression", expression}, {"returnByValue", true}, {"awaitPromise", true}});
  if (answer.contains("exceptionDetails"))
    throw std::runtime_error(answer["exceptionDetails"].dump());
  return answer["result"].value("value", Json());
}

bool Browser::becomes_true(const std::string& expression) {
  const std::string tried =
      "(() => { try { return Boolean(" + expression + "); } catch { return false; } })()";
  for (int i = 0; i < 600; ++i) {
    if (evaluate(tried) == true) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return false;
}

void Browser::screenshot(const std::filesystem::path& path) {
  const std::string picture = call("Page.captureScreenshot", {{"format", "png"}})["data"];
  const auto bytes = data_of_uri("data:image/png;base64," + picture);
  if (!bytes) throw std::runtime_error("the screenshot is no base64");
  write_bytes(path, std::string(text_of(*bytes)));
}

}  // namespace mq::test

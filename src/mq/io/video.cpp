// ffmpeg is started without a shell, with one end of a pair of sockets as its standard input:
// unlike a pipe, a socket whose reader is gone tells so by an error and not by a signal. It runs in
// a group of its own, so that Ctrl-C comes to us alone and we say what becomes of the file.
#include "mq/io/video.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "mq/base/error.h"
#include "mq/image/colour.h"
#include "mq/io/atomic_file.h"
#include "mq/io/picture_check.h"

extern char** environ;

namespace mq {
namespace {

constexpr int most_pixels_a_side = 16384;
constexpr int patience_ms = 50;  // between two looks at whether to stop

/// 4:2:0 halves both sides, so an odd one loses a row or column. sRGB's primaries are BT.709's.
constexpr const char* into_yuv =
    "crop=trunc(iw/2)*2:trunc(ih/2)*2:0:0,scale=out_color_matrix=bt709:out_range=tv,format=yuv420p";

using Words = std::vector<std::string>;

/// How a codec is asked for, in the order of `VideoCodec`, and the files that hold it. Qualities
/// are about alike.
struct Codec {
  const char* name;
  Words words;
  Words files;
};
const std::vector<Codec>& codecs() {
  static const std::vector<Codec> all = {
      {"auto", {}, {".mp4", ".mov", ".webm", ".mkv"}},
      {"h264", {"-c:v", "libx264", "-preset", "medium", "-crf", "16"}, {".mp4", ".mov", ".mkv"}},
      {"h265",
       {"-c:v", "libx265", "-preset", "medium", "-crf", "18", "-x265-params", "log-level=error"},
       {".mp4", ".mov", ".mkv"}},
      {"av1",
       {"-c:v", "libaom-av1", "-crf", "20", "-b:v", "0", "-cpu-used", "6", "-row-mt", "1"},
       {".mp4", ".webm", ".mkv"}},
      {"vp9",
       {"-c:v", "libvpx-vp9", "-crf", "24", "-b:v", "0", "-row-mt", "1"},
       {".webm", ".mp4", ".mkv"}},
      {"ffv1", {"-c:v", "ffv1", "-level", "3", "-pix_fmt", "bgr0"}, {".mkv"}}};
  return all;
}

VideoCodec codec_of(const std::string& extension, VideoCodec asked) {
  if (asked != VideoCodec::automatic) return asked;
  return extension == ".mkv"    ? VideoCodec::ffv1
         : extension == ".webm" ? VideoCodec::vp9
                                : VideoCodec::h264;
}

/// What a kind of file asks of ffmpeg.
Words encoding(const std::filesystem::path& path, VideoCodec asked) {
  const std::string extension = lower_extension(path);
  const VideoCodec codec = codec_of(extension, asked);
  const Words& words = codecs()[std::size_t(codec)].words;
  if (codec == VideoCodec::ffv1) return words;
  std::vector<std::string> all = {"-vf",         into_yuv,      "-color_range",     "tv",
                                  "-colorspace", "bt709",       "-color_primaries", "bt709",
                                  "-color_trc",  "iec61966-2-1"};
  all.insert(all.end(), words.begin(), words.end());
  const bool is_mp4 = extension == ".mp4" || extension == ".mov";
  if (is_mp4) all.insert(all.end(), {"-movflags", "+faststart"});
  if (is_mp4 && codec == VideoCodec::h265) all.insert(all.end(), {"-tag:v", "hvc1"});
  return all;
}

std::vector<std::string> command(const std::filesystem::path& path,
                                 const std::filesystem::path& temporary, int width, int height,
                                 const VideoOptions& options) {
  std::vector<std::string> all = {"ffmpeg",
                                  "-nostdin",
                                  "-loglevel",
                                  "error",
                                  "-y",
                                  "-f",
                                  "rawvideo",
                                  "-pix_fmt",
                                  "rgb24",
                                  "-video_size",
                                  fmt::format("{}x{}", width, height),
                                  "-framerate",
                                  fmt::format("{:.6f}", options.rate),
                                  "-i",
                                  "pipe:0"};
  for (std::string& word : encoding(path, options.codec)) all.push_back(std::move(word));
  // A name that begins with - would be taken for an option, one with : for a protocol.
  all.push_back("file:" + temporary.string());
  return all;
}

std::string last_line(const std::string& text) {
  const std::size_t end = text.find_last_not_of("\n\r ");
  if (end == std::string::npos) return "";
  const std::size_t begin = text.find_last_of("\n\r", end);
  return text.substr(begin == std::string::npos ? 0 : begin + 1,
                     end - (begin == std::string::npos ? 0 : begin + 1) + 1);
}

}  // namespace

std::vector<std::string> video_codec_names() {
  Words names;
  for (const Codec& codec : codecs()) names.emplace_back(codec.name);
  return names;
}

VideoCodec video_codec(const std::string& name) {
  const Words names = video_codec_names();
  const auto at = std::ranges::find(names, name);
  require(at != names.end(), fmt::format("found the video codec '{}', wanted one of {}", name,
                                         fmt::join(names, ", ")));
  return VideoCodec(at - names.begin());
}

void require_video_options(const std::filesystem::path& path, const VideoOptions& options) {
  require(options.rate >= 1e-3 && options.rate <= 1000,
          fmt::format("{}: found {} frames per second, wanted 0.001 to 1000", path.string(),
                      options.rate));
  const Codec& asked = codecs()[std::size_t(options.codec)];
  require(std::ranges::count(asked.files, lower_extension(path)) > 0,
          fmt::format("{}: such a file does not hold {}, which goes into {}", path.string(),
                      asked.name, fmt::join(asked.files, ", ")));
}

bool names_video(const std::filesystem::path& path) {
  static constexpr const char* videos[] = {".mp4", ".mov", ".webm", ".mkv"};
  return std::ranges::count(videos, lower_extension(path)) > 0;
}

static constexpr const char* without_program =
    "videos are made by the program ffmpeg, which is not installed; install it (Debian: apt "
    "install "
    "ffmpeg) or write pictures";

void require_video_program(const std::filesystem::path& path) {
  const char* folders = std::getenv("PATH");
  std::istringstream all(folders ? folders : "/bin:/usr/bin");
  for (std::string folder; std::getline(all, folder, ':');)
    if (::access((std::filesystem::path(folder) / "ffmpeg").c_str(), X_OK) == 0) return;
  throw IoError(fmt::format("cannot write {}: {}", path.string(), without_program));
}

class VideoWriter::Process {
 public:
  Process(const std::filesystem::path& path, int width, int height, const VideoOptions& options,
          const Progress& progress)
      : path_(path), file_(path), progress_(progress), messages_(std::tmpfile()) {
    if (!messages_) fail(std::strerror(errno));
    std::array<int, 2> ends;
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
      fail(std::strerror(errno));
    socket_ = ends[0];
    std::vector<std::string> words = command(path, file_.temporary(), width, height, options);
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, ends[1], STDIN_FILENO);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&files, ::fileno(messages_), STDERR_FILENO);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    posix_spawnattr_setpgroup(&attributes, 0);
    const int failed =
        ::posix_spawnp(&child_, "ffmpeg", &files, &attributes, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
    ::close(ends[1]);
    if (failed == 0) return;
    child_ = 0;
    close_all();
    fail(failed == ENOENT ? without_program : std::strerror(failed));
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  ~Process() {
    if (child_ > 0) {
      ::kill(-child_, SIGKILL);  // and what it has started
      reap(0);
    }
    close_all();
  }

  void send(std::span<const std::uint8_t> bytes) {
    while (!bytes.empty()) {
      progress_.check();
      const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
      if (sent < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) {
        pollfd ready{socket_, POLLOUT, 0};
        ::poll(&ready, 1, patience_ms);
        continue;
      }
      if (sent < 0 && errno == EINTR) continue;
      if (sent < 0) {
        const std::string reason = std::strerror(errno);
        wait();
        fail(reason);
      }
      bytes = bytes.subspan(std::size_t(sent));
    }
  }

  void finish() {
    ::close(socket_);
    socket_ = -1;
    if (const int status = wait(); status != 0)
      fail(WIFSIGNALED(status) ? fmt::format("it was ended by signal {}", WTERMSIG(status))
                               : fmt::format("it ended with status {}", WEXITSTATUS(status)));
    file_.commit();
  }

 private:
  /// Its status, once it has ended.
  int wait() {
    for (;;) {
      if (const auto status = reap(WNOHANG)) return *status;
      progress_.check();
      ::poll(nullptr, 0, patience_ms);
    }
  }

  std::optional<int> reap(int options) {
    int status = 0;
    pid_t ended = 0;
    while ((ended = ::waitpid(child_, &status, options)) < 0 && errno == EINTR) continue;
    if (ended == 0) return {};
    child_ = 0;
    return status;
  }

  void close_all() {
    if (socket_ >= 0) ::close(socket_);
    if (messages_) std::fclose(messages_);
    socket_ = -1;
    messages_ = nullptr;
  }

  /// With ffmpeg's own last words, where it has left any.
  [[noreturn]] void fail(const std::string& reason) const {
    std::string said(4096, '\0');
    if (messages_) {
      std::rewind(messages_);
      said.resize(std::fread(said.data(), 1, said.size(), messages_));
      said = last_line(said);
    } else {
      said.clear();
    }
    throw IoError(fmt::format("cannot write {}: {}", path_.string(),
                              said.empty() ? reason : fmt::format("ffmpeg says: {}", said)));
  }

  std::filesystem::path path_;
  AtomicFile file_;
  Progress progress_;
  std::FILE* messages_;
  int socket_ = -1;
  pid_t child_ = 0;
};

VideoWriter::VideoWriter(const std::filesystem::path& path, int width, int height,
                         const VideoOptions& options, const Progress& progress)
    : path_(path), width_(width), height_(height) {
  require(names_video(path),
          fmt::format("{}: wanted a video's name: .mp4, .mov, .webm or .mkv", path.string()));
  require(width >= 2 && height >= 2 && std::max(width, height) <= most_pixels_a_side,
          fmt::format("{}: found frames of {} x {} pixels, wanted 2 to {} a side", path.string(),
                      width, height, most_pixels_a_side));
  require_video_options(path, options);
  process_ = std::make_unique<Process>(path, width, height, options, progress);
}

VideoWriter::~VideoWriter() = default;

void VideoWriter::write(const Image<float>& picture) {
  require(picture.width() == width_ && picture.height() == height_,
          fmt::format("a frame has {} x {} pixels, and those before have {} x {}", picture.width(),
                      picture.height(), width_, height_));
  const Image<float> rgb = as_rgb(picture, Colour{0, 0, 0});
  std::vector<std::uint8_t> bytes(rgb.values().size());
  std::ranges::transform(rgb.values(), bytes.begin(), [](float v) {
    return std::uint8_t(std::lround(255 * std::clamp(v, 0.0F, 1.0F)));
  });
  process_->send(bytes);
}

std::vector<std::string> VideoWriter::notes() const {
  if (lower_extension(path_) == ".mkv" || (width_ % 2 == 0 && height_ % 2 == 0)) return {};
  return {fmt::format(
      "{}: frames of {} x {} pixels are cut to {} x {}, as colours are kept for two pixels by two; "
      ".mkv keeps them all",
      path_.string(), width_, height_, width_ / 2 * 2, height_ / 2 * 2)};
}

void VideoWriter::finish() { process_->finish(); }

}  // namespace mq

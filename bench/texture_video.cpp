// texture_video FRAMES PSNR NAME=STORE:SIZE:GUTTER[:PICTURES] ... : how large the videos are that
// show captured frames in the atlases of evolving meshes, at equal quality on the surface.
//
// Frames are resampled, made 4:2:0 by ffmpeg, encoded with several qualities (libx264 and libx265,
// preset medium, no other options), decoded again, and compared in luma at the texels of charts
// alone. The size at the PSNR asked for lies between two of them, linear in the logarithm of bytes.
// PICTURES (a name with %04d for the frame's number) are encoded instead of the resampled frames,
// and compared with these.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include <unistd.h>

#include "tool.h"
#include "mq/base/error.h"
#include "mq/io/evolving_file.h"
#include "mq/io/frame_files.h"
#include "mq/io/image_file.h"
#include "mq/io/model.h"
#include "mq/io/vertex_colours.h"
#include "mq/video/gutter.h"
#include "mq/video/texel_owners.h"
#include "mq/video/texture_frame.h"

namespace mq {
namespace {

namespace fs = std::filesystem;

struct Case {
  std::string name, store, gutter, pictures;
  int size = 0;
};

Case parse_case(const std::string& text) {
  const auto equals = text.find('=');
  std::vector<std::string> parts{""};
  for (const char c : text.substr(equals == std::string::npos ? text.size() : equals + 1))
    c == ':' ? parts.emplace_back() : parts.back() += c;
  require(parts.size() == 3 || parts.size() == 4,
          text + ": wanted NAME=STORE:SIZE:GUTTER or NAME=STORE:SIZE:GUTTER:PICTURES");
  return {text.substr(0, equals), parts[0], parts[2], parts.size() == 4 ? parts[3] : "",
          std::stoi(parts[1])};
}

void run(const std::string& command) {
  require(std::system(command.c_str()) == 0, "failed: " + command);
}

/// The video before it is encoded, and where its charts are.
struct Raw {
  fs::path file;
  fs::path truth;  // what is decoded is compared with
  std::vector<Image<char>> charts;
  double texels = 0;  // of charts, mean
};

Image<char> texels_of_charts(const Mesh& mesh, int size) {
  const TexelOwners owners(mesh, size, size, 1, 0.71);
  Image<char> inside(size, size, 1);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) inside(x, y) = owners.owner(x, y).triangle >= 0;
  return inside;
}

/// Pictures to 4:2:0.
class RawVideo {
 public:
  RawVideo(const fs::path& file, int side) {
    const std::string size = std::to_string(side) + "x" + std::to_string(side);
    pipe_ = popen(("ffmpeg -v error -y -f rawvideo -pix_fmt rgb24 -s " + size +
                   " -i - -pix_fmt yuv420p -f rawvideo " + file.string())
                      .c_str(),
                  "w");
    require(pipe_ != nullptr, "ffmpeg does not start");
  }
  void add(const Image<float>& picture) {
    std::vector<unsigned char> bytes;
    for (const float v : picture.values())
      bytes.push_back((unsigned char)std::lround(255 * std::clamp(v, 0.0F, 1.0F)));
    fwrite(bytes.data(), 1, bytes.size(), pipe_);
  }
  void end() { require(pclose(pipe_) == 0, "ffmpeg failed"); }

 private:
  FILE* pipe_;
};

Raw make_raw(const Case& wanted, const std::string& frames, const fs::path& folder) {
  const EvolvingReader reader(wanted.store);
  std::vector<int> numbers;
  for (const StoredFrame& frame : reader.frames()) numbers.push_back(frame.number);
  const std::vector<FrameFile> files = find_frames(frames, numbers);
  Raw raw{folder / (wanted.name + ".yuv"), folder / (wanted.name + "_truth.yuv"), {}, 0};
  RawVideo video(raw.file, wanted.size), truth(raw.truth, wanted.size);
  Image<float> before;
  for (std::size_t f = 0; f < files.size(); ++f) {
    const EvolvingSegment segment = reader.segment(reader.frames()[f].segment);
    const Mesh mesh = mesh_of(segment, reader.positions(int(f)));
    const Model captured = read_model(files[f].path);
    TextureFrame frame =
        resample_texture(mesh, captured.mesh, surface_colours(captured),
                         {.width = wanted.size, .height = wanted.size, .samples = 1});
    truth.add(frame.picture);
    if (!wanted.pictures.empty()) {
      char name[1000];
      std::snprintf(name, sizeof name, wanted.pictures.c_str(), numbers[f]);
      frame.picture = read_texture(name).pixels;
      require(frame.picture.width() == wanted.size && frame.picture.channels() == 3,
              std::string(name) + ": wanted red, green and blue, and the side of the case");
    }
    raw.charts.push_back(texels_of_charts(mesh, wanted.size));
    if (wanted.gutter == "held" && !before.empty())
      hold_gutter(frame.inside, seen_margin, before, frame.picture);
    before = frame.picture;
    video.add(frame.picture);
    for (const char inside : raw.charts.back().values())
      raw.texels += double(inside) / double(files.size());
  }
  video.end();
  truth.end();
  return raw;
}

/// Of luma at the texels of charts, over all frames.
double psnr(const Raw& raw, const fs::path& decoded, int size) {
  std::ifstream a(raw.truth, std::ios::binary), b(decoded, std::ios::binary);
  const std::size_t luma = std::size_t(size) * size, all = luma + 2 * (luma / 4);
  std::vector<char> x(all), y(all);
  double squares = 0, count = 0;
  for (const Image<char>& charts : raw.charts) {
    a.read(x.data(), std::streamsize(all));
    b.read(y.data(), std::streamsize(all));
    require(bool(a) && bool(b), decoded.string() + " is too short");
    for (std::size_t i = 0; i < luma; ++i) {
      if (!charts.values()[i]) continue;
      const double d = double((unsigned char)x[i]) - double((unsigned char)y[i]);
      squares += d * d;
      ++count;
    }
  }
  return 10 * std::log10(219.0 * 219.0 / (squares / count));
}

/// Bytes at a PSNR.
double bytes_at(const Raw& raw, const std::string& codec, int size, double wanted,
                const fs::path& folder) {
  const std::string in = " -f rawvideo -pix_fmt yuv420p -r 30 -s " + std::to_string(size) + "x" +
                         std::to_string(size) + " -i " + raw.file.string();
  const fs::path coded = folder / "coded.mp4", decoded = folder / "decoded.yuv";
  double last_bytes = 0, last_psnr = 0;
  for (int crf = 20; crf <= 44; crf += 6) {
    run("ffmpeg -v error -y" + in + " -c:v " + codec + " -preset medium -crf " +
        std::to_string(crf) + (codec == "libx265" ? " -x265-params log-level=error" : "") + " " +
        coded.string());
    run("ffmpeg -v error -y -i " + coded.string() + " -pix_fmt yuv420p -f rawvideo " +
        decoded.string());
    const double bytes = double(fs::file_size(coded)), found = psnr(raw, decoded, size);
    std::cerr << codec << " crf " << crf << ": " << bytes << " bytes, " << found << " dB\n";
    if (found < wanted) {
      require(last_bytes > 0, "the PSNR asked for is above that of crf 20");
      const double t = (wanted - found) / (last_psnr - found);
      return std::exp(t * std::log(last_bytes) + (1 - t) * std::log(bytes));
    }
    last_bytes = bytes;
    last_psnr = found;
  }
  throw InvalidInput("the PSNR asked for is below that of crf 44");
}

int main(int count, char** words) {
  require(count >= 4, "usage: texture_video FRAMES PSNR NAME=STORE:SIZE:GUTTER[:PICTURES] ...");
  const fs::path folder = fs::temp_directory_path() / ("texture_video_" + std::to_string(getpid()));
  fs::create_directories(folder);
  std::printf(
      "| atlas | side | texels of charts | H.264, bytes | H.265, bytes |\n|---|---|---|---|---|\n");
  for (int i = 3; i < count; ++i) {
    const Case wanted = parse_case(words[i]);
    const Raw raw = make_raw(wanted, words[1], folder);
    const double target = std::stod(words[2]);
    const double h264 = bytes_at(raw, "libx264", wanted.size, target, folder),
                 h265 = bytes_at(raw, "libx265", wanted.size, target, folder);
    std::printf("| %s | %d | %.0f | %.0f | %.0f |\n", wanted.name.c_str(), wanted.size, raw.texels,
                h264, h265);
    std::fflush(stdout);
    fs::remove(raw.file);
    fs::remove(raw.truth);
  }
  fs::remove_all(folder);
  return 0;
}

}  // namespace
}  // namespace mq

int main(int count, char** words) { return mq::run_tool(mq::main, count, words); }

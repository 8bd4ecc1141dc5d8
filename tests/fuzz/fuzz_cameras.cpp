// Any bytes in a file of cameras of any kind are refused by an error of ours, or are cameras that can be
// written as our own and read again. The first byte chooses the kind; a byte 0xff ends a file of several.

#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "mq/base/error.h"
#include "mq/io/cameras.h"

namespace {

using namespace mq;
namespace fs = std::filesystem;

/// The files of each kind, in the order in which their bytes come; the last is the one that is read.
const std::vector<std::vector<std::string>> kinds = {
    {"images.txt", "cameras.txt"}, {"images.bin", "cameras.bin"}, {"transforms.json"}, {"ours.json"},
    {"list.txt", "bundle.out"},    {"cameras.xml"},               {"photo.xmp"},       {"scene.gltf"},
    {"scene.glb"},                 {"scene.mvs"}};

const fs::path& folder() {
  static const fs::path made = [] {
    const fs::path at = fs::path("/dev/shm") / ("fuzz_cameras." + std::to_string(::getpid()));
    fs::create_directories(at);
    return at;
  }();
  return made;
}

void write(const fs::path& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
}

/// Writes the files of a kind, and returns the one to be read.
fs::path write_kind(const std::vector<std::string>& files, std::string_view bytes) {
  for (const std::string& file : files) {
    const std::size_t end = file == files.back() ? bytes.size() : std::min(bytes.find('\xff'), bytes.size());
    write(folder() / file, bytes.substr(0, end));
    bytes.remove_prefix(std::min(end + 1, bytes.size()));
  }
  return folder() / files.back();
}

void read_and_write(const fs::path& path) {
  CamerasOptions options;
  options.images = {folder()};
  options.missing = options.unreadable = CamerasOptions::Missing::list;
  const CameraSet set = read_camera_set(path, options);
  std::vector<Photograph> with_size;
  for (const Photograph& photograph : set.missing)
    if (photograph.camera.width > 0 && photograph.camera.height > 0) with_size.push_back(photograph);
  if (with_size.empty()) return;
  const fs::path written = folder() / "written.json";
  write_cameras(written, with_size);
  if (read_camera_set(written, options).missing.size() != with_size.size()) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  if (size == 0) return 0;
  const std::vector<std::string>& files = kinds[data[0] % kinds.size()];
  try {
    read_and_write(write_kind(files, {reinterpret_cast<const char*>(data) + 1, size - 1}));
  } catch (const Error&) {
  }
  for (const std::string& file : files) fs::remove(folder() / file);
  return 0;
}

// The module is looked for by its name, as a shared library that the program is linked with would be:
// in the program's run path, which installing and linking by CMake or pkg-config see to, then in
// LD_LIBRARY_PATH and the system's folders.

#include "mq/io/detail/picture_codec.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include "mq/base/error.h"

namespace mq {
namespace {

[[noreturn]] void fail_to_load(const std::string& why) {
  throw Unsupported(fmt::format(
      "pictures cannot be read or written, as {} cannot be used: {}; put that of the same build "
      "beside the program, into lib/marquetry beside its bin, or into a folder that LD_LIBRARY_PATH "
      "names",
      picture_module, why));
}

const PictureCodec& load_codec() {
  const auto reason = [] {
    const char* said = ::dlerror();
    return std::string(said ? said : "no reason given");
  };
  void* const module = ::dlopen(picture_module, RTLD_LAZY | RTLD_LOCAL);
  if (module == nullptr) fail_to_load(reason());
  void* const symbol = ::dlsym(module, picture_codec_symbol);
  if (symbol == nullptr) fail_to_load(reason());
  const PictureCodec* codec = reinterpret_cast<PictureCodecOfModule>(symbol)(MARQUETRY_VERSION);
  if (codec == nullptr) fail_to_load(fmt::format("it is not of version {}", MARQUETRY_VERSION));
  return *codec;
}

}  // namespace

const PictureCodec& picture_codec() {
  static const PictureCodec& codec = load_codec();
  return codec;
}

}  // namespace mq

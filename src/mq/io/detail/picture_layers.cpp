// OpenImageIO sorts the channels of a part by what is before their last dot, R, G, B and A first: those of a
// layer lie side by side. What is not processed goes from file to file as it is stored, without conversion.

#include "mq/io/detail/picture_layers.h"

#include <OpenImageIO/strutil.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <string_view>

#include "mq/base/error.h"
#include "mq/io/bytes.h"
#include "mq/io/detail/picture_alpha.h"
#include "mq/io/detail/picture_head.h"
#include "mq/io/detail/picture_memory.h"
#include "mq/io/detail/picture_reader.h"
#include "mq/io/picture_check.h"

namespace mq {
namespace {

using OIIO::ImageSpec;
using OIIO::TypeDesc;

std::string before_last_dot(const std::string& channel) {
  const std::size_t dot = channel.rfind('.');
  return dot == channel.npos ? "" : channel.substr(0, dot);
}

std::string after_last_dot(const std::string& channel) { return channel.substr(channel.rfind('.') + 1); }

bool is_called(const std::string& channel, std::string_view letter, std::string_view word) {
  const std::string own = after_last_dot(channel);
  return OIIO::Strutil::iequals(own, letter) || OIIO::Strutil::iequals(own, word);
}

bool is_alpha(const std::string& channel) { return is_called(channel, "A", "alpha"); }

/// Where R, G and B follow each other among channels begin … end − 1; `end`: nowhere.
int place_of_colours(const ImageSpec& part, int begin, int end) {
  const auto& names = part.channelnames;
  for (int c = begin; c + 2 < end; ++c)
    if (is_called(names[c], "R", "red") && is_called(names[c + 1], "G", "green") &&
        is_called(names[c + 2], "B", "blue"))
      return c;
  return end;
}

/// The part's name and the layer's; blender writes the first before the second as well.
std::string joined_name(const std::string& part, const std::string& layer) {
  if (part.empty() || layer == part || layer.starts_with(part + ".")) return layer;
  return layer.empty() ? part : part + "." + layer;
}

/// Those of channels begin … end − 1, which have one name before the last dot.
void add_layers(const ImageSpec& part, int index, const std::string& group, int begin, int end,
                std::vector<FileLayer>& layers) {
  const auto add_single = [&](int c) {
    layers.push_back({joined_name(group, after_last_dot(part.channelnames[c])), index, c, 1, false});
  };
  const int colours = place_of_colours(part, begin, end);
  const bool has_colours = colours < end;
  const int first = has_colours ? colours : begin;
  const int after = !has_colours                                                            ? end
                    : colours + 3 < end && is_alpha(part.channelnames[colours + 3]) ? colours + 4
                                                                                            : colours + 3;
  for (int c = begin; c < first; ++c) add_single(c);
  std::string name = group;
  if (name.empty()) {
    const bool letters = std::all_of(part.channelnames.begin() + first, part.channelnames.begin() + after,
                                     [](const std::string& channel) { return channel.size() == 1; });
    for (int c = first; c < after; ++c)
      name += (letters || c == first ? "" : "+") + part.channelnames[c];
  }
  layers.push_back({name, index, first, after - first, has_colours});
  for (int c = after; c < end; ++c) add_single(c);
}

/// Formats of a part's channels, one each.
std::vector<TypeDesc> formats_of(const ImageSpec& spec) {
  std::vector<TypeDesc> formats;
  for (int c = 0; c < spec.nchannels; ++c) formats.push_back(spec.channelformat(c));
  return formats;
}

void set_formats(const std::vector<TypeDesc>& formats, ImageSpec& spec) {
  spec.format = formats.front();
  for (const TypeDesc& format : formats)
    spec.format = TypeDesc(TypeDesc::basetype_merge(spec.format, format));
  const bool alike = std::ranges::all_of(formats, [&](const TypeDesc& f) { return f == formats.front(); });
  spec.channelformats = alike ? std::vector<TypeDesc>() : formats;
}

bool loses(const std::string& compression) {
  static constexpr std::array<std::string_view, 3> with_loss = {"pxr24", "b44", "dwa"};
  return std::ranges::any_of(with_loss, [&](std::string_view one) { return compression.starts_with(one); });
}

/// Without what says how the old file was laid out. Returns the compression that would have lost.
std::string make_writable(ImageSpec& spec) {
  for (const char* tag : {"oiio:subimages", "openexr:chunkCount", "openexr:lineOrder", "openexr:levelmode",
                          "openexr:roundingmode"})
    spec.erase_attribute(tag);
  // An empty date keeps the library from writing today's: equal pictures are equal files.
  if (spec.find_attribute("DateTime") == nullptr) spec["DateTime"] = "";
  const std::string compression = spec.get_string_attribute("compression");
  if (!loses(compression)) return "";
  spec["compression"] = "zip";
  return compression;
}

std::size_t channel_offset(const ImageSpec& spec, int c) { return spec.pixel_bytes(0, c, true); }

/// The same pixels where the layer's channels have other formats; their values are left to be filled in.
std::vector<std::byte> laid_out_anew(const ImageSpec& from, const std::vector<std::byte>& pixels,
                                     const ImageSpec& to, const FileLayer& layer) {
  std::vector<std::byte> result(to.image_bytes(true));
  const std::size_t old_step = from.pixel_bytes(true), step = to.pixel_bytes(true);
  const std::size_t count = result.size() / step;
  for (int c = 0; c < to.nchannels; ++c) {
    if (c >= layer.first && c < layer.first + layer.count) continue;
    const std::size_t old_at = channel_offset(from, c), at = channel_offset(to, c);
    const std::size_t size = to.channelformat(c).size();
    for (std::size_t i = 0; i < count; ++i)
      std::memcpy(result.data() + i * step + at, pixels.data() + i * old_step + old_at, size);
  }
  return result;
}

std::int64_t put_values(std::vector<float> values, const ImageSpec& spec, const FileLayer& layer,
                        std::vector<std::byte>& pixels) {
  std::int64_t clamped = 0;
  for (int c = 0; c < layer.count; ++c) {
    const TypeDesc type = spec.channelformat(layer.first + c);
    constexpr float largest_of_half = 65504;
    const float largest = type == TypeDesc::HALF ? largest_of_half : std::numeric_limits<float>::max();
    for (std::size_t i = std::size_t(c); i < values.size(); i += std::size_t(layer.count)) {
      clamped += std::abs(values[i]) > largest;
      values[i] = std::clamp(values[i], -largest, largest);
    }
    OIIO::convert_image(1, spec.width, spec.height, 1, values.data() + c, TypeDesc::FLOAT,
                        OIIO::stride_t(layer.count * sizeof(float)), OIIO::AutoStride, OIIO::AutoStride,
                        pixels.data() + channel_offset(spec, layer.first + c), type,
                        OIIO::stride_t(spec.pixel_bytes(true)), OIIO::AutoStride, OIIO::AutoStride, 1);
  }
  return clamped;
}

}  // namespace

std::vector<ImageSpec> heads_of(OIIO::ImageInput& input) {
  std::vector<ImageSpec> parts;
  for (int part = 0; input.seek_subimage(part, 0); ++part) parts.push_back(input.spec());
  input.seek_subimage(0, 0);
  return parts;
}

std::vector<FileLayer> layers_of(const std::vector<ImageSpec>& parts) {
  std::vector<FileLayer> layers;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const ImageSpec& part = parts[i];
    const std::string name = parts.size() > 1 ? part.get_string_attribute("oiio:subimagename") : "";
    for (int begin = 0, end = 0; begin < part.nchannels; begin = end) {
      const std::string prefix = before_last_dot(part.channelnames[begin]);
      while (end < part.nchannels && before_last_dot(part.channelnames[end]) == prefix) ++end;
      add_layers(part, int(i), joined_name(name, prefix), begin, end, layers);
    }
  }
  return layers;
}

std::size_t layer_named(const std::vector<FileLayer>& layers, const std::string& name, const std::string& file) {
  if (name.empty()) {
    const auto colour = std::ranges::find_if(layers, &FileLayer::is_colour);
    return colour == layers.end() ? 0 : std::size_t(colour - layers.begin());
  }
  const auto found = std::ranges::find(layers, name, &FileLayer::name);
  if (found != layers.end() && std::ranges::count(layers, name, &FileLayer::name) == 1)
    return std::size_t(found - layers.begin());
  std::string names;
  for (const FileLayer& layer : layers) names += (names.empty() ? "" : ", ") + shown(layer.name);
  throw InvalidInput(fmt::format("{}: has {} layer '{}'; there {} {}", file,
                                 found == layers.end() ? "no" : "more than one", name,
                                 layers.size() == 1 ? "is" : "are", names));
}

ImageSpec head_of_layer(const ImageSpec& part, const FileLayer& layer) {
  ImageSpec spec = part;
  spec.nchannels = layer.count;
  const auto first = part.channelnames.begin() + layer.first;
  spec.channelnames.assign(first, first + layer.count);
  const std::vector<TypeDesc> formats = formats_of(part);
  set_formats({formats.begin() + layer.first, formats.begin() + layer.first + layer.count}, spec);
  const bool alpha = (layer.count == 2 || layer.count == 4) && is_alpha(spec.channelnames.back());
  spec.alpha_channel = alpha ? layer.count - 1 : -1;
  spec.z_channel = -1;
  return spec;
}

bool fits_its_layer(const Texture& texture) {
  const auto* read = static_cast<const ImageSpec*>(texture.format.tags.get());
  return texture.format.layers != nullptr && read != nullptr && read->width == texture.pixels.width() &&
         read->height == texture.pixels.height() && read->nchannels == texture.pixels.channels();
}

EncodedPicture encode_among_layers(const Texture& texture, const std::string& name, Depth depth,
                                   std::int64_t& clamped, const Progress& progress) {
  const PictureLayers& source = *texture.format.layers;
  const auto& head = *static_cast<const ImageSpec*>(texture.format.tags.get());
  OpenPicture from = open_picture(*source.file, name);
  const std::vector<ImageSpec> read = heads_of(*from.input);
  const FileLayer layer = layers_of(read).at(source.chosen);
  std::vector<ImageSpec> parts = read;
  EncodedPicture encoded;
  std::string lossy;
  for (ImageSpec& part : parts)
    if (const std::string one = make_writable(part); !one.empty()) lossy = one;
  if (!lossy.empty())
    encoded.notes.push_back(fmt::format("{}: compressed by zip, as {} would change the layers that nobody touched",
                                        name, lossy));
  if (depth_of(head.format) != depth) {
    std::vector<TypeDesc> formats = formats_of(read[std::size_t(layer.part)]);
    std::fill_n(formats.begin() + layer.first, layer.count, type_of(depth));
    set_formats(formats, parts[std::size_t(layer.part)]);
  }
  const auto output = OIIO::ImageOutput::create("openexr");
  if (!output) throw Unsupported(fmt::format("{}: this build cannot write openexr; choose .png", name));
  const MemoryFile file;
  const auto check = [&](bool ok, const char* what, const std::string& why) {
    if (!ok) fail_picture(name, fmt::format("{}: {}", what, explain(why)));
  };
  constexpr const char* unwritten = "cannot be written as openexr";
  check(output->open(file.name(), int(parts.size()), parts.data()), unwritten, output->geterror());
  for (std::size_t i = 0; i < parts.size(); ++i) {
    std::vector<std::byte> pixels(read[i].image_bytes(true));
    check(from.input->read_image(int(i), 0, 0, read[i].nchannels, TypeDesc::UNKNOWN, pixels.data()),
          "the file that its other layers are taken from is cut short or damaged; copy it again",
          from.input->geterror());
    if (int(i) == layer.part) {
      if (formats_of(parts[i]) != formats_of(read[i]))
        pixels = laid_out_anew(read[i], pixels, parts[i], layer);
      const auto values = texture.pixels.values();
      clamped = put_values(is_associated(head, "openexr") ? multiplied_by_alpha(values, layer.count)
                                                          : std::vector<float>(values.begin(), values.end()),
                           parts[i], layer, pixels);
    }
    if (i > 0)
      check(output->open(file.name(), parts[i], OIIO::ImageOutput::AppendSubimage), unwritten,
            output->geterror());
    check(output->write_image(TypeDesc::UNKNOWN, pixels.data()), unwritten, output->geterror());
    progress.at(double(i + 1) / double(parts.size()));
  }
  check(output->close(), unwritten, output->geterror());
  encoded.bytes = file.bytes();
  return encoded;
}

}  // namespace mq

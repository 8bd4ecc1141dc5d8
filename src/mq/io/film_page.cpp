#include "mq/io/film_page.h"

#include <fmt/format.h>

#include <cstddef>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "mq/base/error.h"
#include "mq/base/option_names.h"
#include "mq/io/uri.h"

namespace mq {
namespace {

using OrderedJson = nlohmann::ordered_json;

/// A browser keeps at most this many characters in one string; base64 makes four of three bytes.
constexpr std::size_t most_bytes = 380'000'000;

std::string uri_of(const std::string& type, ByteView bytes, const std::string& what) {
  require(bytes.size() <= most_bytes,
          fmt::format("{} has {} MB, and a browser takes {} at once: take fewer frames ({}), or "
                      "smaller textures ({})",
                      what, bytes.size() / 1'000'000, most_bytes / 1'000'000, option_name("frames"),
                      option_name("side")));
  return data_uri(type, bytes);
}

/// The film as a statement of JavaScript.
std::string film_script(const Film& film, const FilmPageOptions& options) {
  OrderedJson description = OrderedJson::parse(film.description);
  description["title"] = options.title;
  description["rate"] = options.rate;
  const auto data = [](const char* type, ByteView bytes, const char* what) { return uri_of(type, bytes, what); };
  const bool is_beside = !options.store_name.empty();
  description["lives"] = data("application/octet-stream", film.lives, "what says how long charts live");
  description["store"] = is_beside ? OrderedJson(uri_of_name(options.store_name)) : OrderedJson(nullptr);
  description["video"] = nullptr;
  if (is_beside) {
    if (!options.video_name.empty()) description["video"] = uri_of_name(options.video_name);
  } else {
    description["manifest"] = film.manifest;
    description["blocks"] = OrderedJson::array();
    for (const Bytes& block : film.blocks)
      description["blocks"].push_back(data("application/octet-stream", block, "a group of frames of the film"));
    if (!options.video.empty())
      description["video"] = data(options.video_type.c_str(), options.video, "the texture video");
  }
  // "</" would end the script; in JSON it may be written so.
  std::string text = description.dump(-1, ' ', true, OrderedJson::error_handler_t::replace);
  for (std::size_t at = 0; (at = text.find("</", at)) != std::string::npos; at += 3)
    text.insert(at + 1, "\\");
  return fmt::format("const film = {};", text);
}

void put_script(std::string& page, std::string_view name, std::string_view script) {
  const std::string place = fmt::format(" src=\"{}\">", name);
  const std::size_t at = page.find(place);
  if (at == std::string::npos) throw std::logic_error(fmt::format("the page has no {}", name));
  page.replace(at, place.size(), fmt::format(">\n{}", script));
}

}  // namespace

std::string film_page(std::string_view page, std::span<const PageScript> scripts, const Film& film,
                      const FilmPageOptions& options) {
  std::string html(page);
  for (const auto& [name, script] : scripts) put_script(html, name, script);
  put_script(html, "film.js", film_script(film, options));
  return html;
}

}  // namespace mq

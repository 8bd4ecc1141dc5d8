#pragma once
/// A film (film.h) as a page of HTML, which a browser plays: with all in it, so that it fetches nothing, or with the
/// film in files beside it.

#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "mq/io/film.h"
#include "mq/io/video.h"

namespace mq {

struct FilmPageOptions {
  std::string title = {};
  double rate = VideoOptions{}.rate;  ///< frames a second
  std::string video_type = {};        ///< of the texture video, such as video/mp4
  ByteView video = {};                ///< a picture for each frame; empty: shapes alone
  /// Names of the manifest and the video where they are beside the page; empty: all is in the page.
  std::string store_name = {}, video_name = {};
};

/// A script of the page and the name that the page has for it.
using PageScript = std::pair<std::string_view, std::string_view>;

/// `page` with each script inside in place of ` src="NAME"`, and the film in place of that of film.js:
/// `const film = {…};`, the film's description with these options, and its store, lives and the video as texts and data
/// URIs, or the names of the files they are in. Throws `InvalidInput` where one of them is longer than a browser keeps
/// in a string (380 MB), `std::logic_error` where the page does not name a script.
std::string film_page(std::string_view page, std::span<const PageScript> scripts, const Film& film,
                      const FilmPageOptions& options);

}  // namespace mq

#pragma once
/// Several pictures on one page, each with its label below.

#include <string>
#include <vector>

#include "mq/image/colour.h"
#include "mq/image/image.h"

namespace mq {

struct Tile {
  Image<float> image;
  std::string label;
};

struct SheetOptions {
  int columns = 0;         ///< 0: as near to a square page as the tiles allow
  int gap = 16;            ///< pixels between tiles and around them
  int text_scale = 2;      ///< of labels; a label too long for its tile is cut and ends in dots
  std::string title = {};  ///< above all tiles, twice as large, in as many lines as it takes
  Colour background = {0.96f, 0.96f, 0.965f};
};

/// Red, green and blue. All cells have the size of the largest tile; smaller ones are centred.
/// Throws `InvalidInput` when there are no tiles or one has no pixels.
Image<float> contact_sheet(const std::vector<Tile>& tiles, const SheetOptions& options = {});

}  // namespace mq

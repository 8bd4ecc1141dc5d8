#pragma once
/// The picture of a material of USD (UsdShade, with the nodes of the UsdPreviewSurface specification).

#include <string>
#include <string_view>
#include <vector>

#include "mq/io/detail/usd_text.h"

namespace mq {

/// What a surface shows as its base colour.
struct UsdPicture {
  std::string file;                ///< as the layer names it; empty: none
  std::string uv_set;              ///< the primvar that it is placed by, "st"; empty: the material does not say
  std::vector<std::string> notes;  ///< what it says that is not followed
};

/// The picture that is connected to the diffuse colour of the preview surface in `material` ("/Looks/skin"), which
/// may lead over inputs of materials and node graphs. Of a file that changes over time it is the first.
UsdPicture usd_picture(const UsdText& text, std::string_view material);

}  // namespace mq

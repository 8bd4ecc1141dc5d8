#pragma once
/// Numbers of things as a sentence says them: "1 triangle", "3 vertices", "2 of them: ids 4, 9".

#include <cstdint>
#include <string>

#include "mq/base/defect.h"

namespace mq {

/// More than one of them: "triangles", "vertices", "half-edges", "bodies". `noun` ends in the word
/// that changes.
std::string plural(const std::string& noun);

/// "1 triangle", "3 triangles", "0 triangles".
std::string counted(std::int64_t count, const std::string& noun);

/// The first elements of a defect: "id 4", "ids 4, 9" or, beyond `most`, "ids 4, 9, ..."; empty
/// where none are listed.
std::string ids_text(const Defect& defect, int most = 5);

/// Its message and how many there are: "triangles without area: no integral sees them (2 of them:
/// ids 4, 9)".
std::string sentence(const Defect& defect);

}  // namespace mq

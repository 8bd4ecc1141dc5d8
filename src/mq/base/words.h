#pragma once
/// Numbers of things as a sentence says them: "1 triangle", "3 vertices", "2 of them: ids 4, 9".

#include <cstdint>
#include <span>
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

/// One line of it: "2 triangles without area: no integral sees them"; its sentence where it has no brief.
std::string short_sentence(const Defect& defect);

/// Where texels are, a rest after the first `most`: "in 1 place, at column 3, row 5", "in 40 places; the
/// largest: 12 at column 3, row 5; 9 at column 70, row 2"; where `textures` has several names, or is empty
/// and places are in others than the first, each with its texture. Empty where there are no places.
std::string places_text(std::span<const Defect::Place> places, std::int64_t count,
                        std::span<const std::string> textures = {}, int most = 3);

/// Its message and how many there are: "triangles without area: no integral sees them (2 of them:
/// ids 4, 9)". Of texels it says the places.
std::string sentence(const Defect& defect);

}  // namespace mq

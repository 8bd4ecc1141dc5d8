#pragma once
/// A short sequence that the program makes.

#include <gtest/gtest.h>

#include <string>

#include "cli/models.h"

namespace mq::test {

/// Frames 0 to `last` of a small body, in body/.
inline void make_body(const Folder& folder, const std::string& name, int last) {
  ASSERT_EQ(marquetry(folder, {"sample", name, "-o", "body/", "--triangles", "1200", "--frames",
                               "0-" + std::to_string(last)})
                .status,
            0);
}

}  // namespace mq::test

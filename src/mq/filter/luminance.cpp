#include "mq/filter/luminance.h"

#include "mq/base/error.h"
#include "mq/image/colour.h"

namespace mq {

Signal luminance(const Signal& colours) {
  require(colours.cols() > 0, "luminance is of colours, and the signal has no channels");
  if (colour_channels(int(colours.cols())) < 3) return colours.leftCols(1);
  return 0.2126 * colours.col(0) + 0.7152 * colours.col(1) + 0.0722 * colours.col(2);
}

Signal with_luminance(const Signal& colours, const Signal& before, const Signal& after) {
  require(before.rows() == colours.rows() && after.rows() == colours.rows(),
          "luminance of another number of unknowns than the colours");
  Signal changed = colours;
  changed.leftCols(colour_channels(int(colours.cols()))).colwise() += (after - before).col(0);
  return changed;
}

}  // namespace mq

#include "places.h"

namespace mq::places {

std::filesystem::path source() { return MQ_SOURCE_DIR; }
std::filesystem::path data() { return MQ_DATA_DIR; }
std::filesystem::path program() { return MQ_PROGRAM; }

}  // namespace mq::places

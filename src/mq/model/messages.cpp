#include "mq/model/messages.h"

namespace mq {

void Messages::remark(const std::string&) {}
void Messages::warning(const std::string&) {}
void Messages::safe(const std::string&) {}

}  // namespace mq

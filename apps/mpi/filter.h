#pragma once
/// The verb filter of marquetry-mpi.

#include "shell/verb.h"

namespace mq::shared {

app::Verb filter_verb();

}  // namespace mq::shared

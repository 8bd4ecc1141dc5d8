#pragma once
/// The verbs whose work several processes share.

#include "shell/verb.h"

namespace mq::shared {

/// What the tables of all these verbs have in common: the program's name, and one thread each unless asked otherwise,
/// as there are as many processes as the machine is to be busy with.
inline void describe_program(OptionTable& table) {
  table.of_program("marquetry-mpi").with_default("threads", "1");
}

app::Verb denoise_verb();
app::Verb fill_verb();
app::Verb filter_verb();
app::Verb geodesic_verb();
app::Verb seams_verb();
app::Verb stitch_verb();

}  // namespace mq::shared

#pragma once
/// The verbs whose work several processes share.

#include "shell/verb.h"

namespace mq::shared {

app::Verb denoise_verb();
app::Verb fill_verb();
app::Verb filter_verb();
app::Verb geodesic_verb();
app::Verb seams_verb();
app::Verb stitch_verb();

}  // namespace mq::shared

#include "shell/verb.h"

namespace mq::app {

#define MARQUETRY_VERB(name) Verb name##_verb();
#include "verb_list.inc"
#undef MARQUETRY_VERB

std::vector<Verb> all_verbs() {
  return {
#define MARQUETRY_VERB(name) name##_verb(),
#include "verb_list.inc"
#undef MARQUETRY_VERB
  };
}

}  // namespace mq::app

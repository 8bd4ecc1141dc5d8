#pragma once
/// Which frames of an evolving mesh are meant.

#include <vector>

#include "mq/io/evolving_file.h"
#include "shell/run.h"

namespace mq::app {

/// Adds --frames.
void add_evolving_frames_option(OptionTable& table);

/// Indices of the frames that --frames says, in that order, or of all. Throws `InvalidInput` where
/// there is none of them.
std::vector<int> wanted_frames(const OptionValues& options, const EvolvingReader& reader);

/// The numbers of frames.
std::vector<int> numbers_of(const EvolvingReader& reader, const std::vector<int>& frames);

/// Whether frames have texture coordinates: all of a store do, or none.
bool has_atlas(const EvolvingReader& reader);

/// Throws `InvalidInput`, saying how to get one, where a store has no atlas.
void require_atlas(const EvolvingReader& reader);

/// Says what of the store is broken and left out, if anything is: `EvolvingReader::broken`.
void warn_of_broken(Terminal& terminal, const EvolvingReader& reader);

/// Says which frames the store cannot give, if there are any: `EvolvingReader::damaged`.
void warn_of_damage(Terminal& terminal, const EvolvingReader& reader,
                    const std::vector<int>& damaged);

}  // namespace mq::app

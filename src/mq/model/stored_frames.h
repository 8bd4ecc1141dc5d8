#pragma once
/// Which frames of a stored evolving mesh are meant, and which can be had.

#include <filesystem>
#include <string>
#include <vector>

#include "mq/io/evolving_file.h"
#include "mq/io/followed_frame.h"
#include "mq/model/messages.h"

namespace mq {

/// Indices of the frames with these numbers, in that order; of all where there are no numbers.
/// Throws `InvalidInput`, which begins with `prefix`, where one is not there; and where none is.
std::vector<int> frames_with(const EvolvingReader& reader, const std::vector<int>& numbers,
                             const std::string& prefix = {});

/// The numbers of frames (indices). Throws `InvalidInput` where the store has not that many.
std::vector<int> numbers_of(const EvolvingReader& reader, const std::vector<int>& frames);

/// What the store says of how its frames were followed.
std::vector<FollowedFrame> followed_frames(const EvolvingReader& reader);

/// Whether frames have texture coordinates: all of a store do, or none.
bool has_atlas(const EvolvingReader& reader);

/// What lengths of its frames are multiplied by in a file of this name: glTF counts in metres, others keep the unit.
double unit_in(const std::filesystem::path& file, const EvolvingReader& reader);

/// Throws `InvalidInput`, saying how to get one, where a store has no atlas.
void require_atlas(const EvolvingReader& reader);

/// Warns of what is broken and left out, if anything is: `EvolvingReader::broken`.
void warn_of_broken(Messages& messages, const EvolvingReader& reader);

/// Warns of frames that the store cannot give, if there are any: `EvolvingReader::damaged`.
void warn_of_damage(Messages& messages, const EvolvingReader& reader,
                    const std::vector<int>& damaged);

}  // namespace mq

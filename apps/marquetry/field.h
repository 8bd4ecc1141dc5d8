#pragma once
/// A field that a verb computed, in place of the model's pictures or colours.

#include <filesystem>
#include <memory>

#include "domain.h"
#include "mq/io/model.h"

namespace mq::app {

/// The texels of the scene, or its vertices where `--vertices` is given or there are no texture
/// coordinates. The verb must have the option.
std::unique_ptr<Domain> make_domain(
    Run& run, const Scene& scene, const Progress& progress,
    TexelDomain::SharedTexels shared = TexelDomain::SharedTexels::one_unknown);

/// Whether that will be vertices.
bool works_at_vertices(const OptionValues& options, const Scene& scene);

/// Whether a file of this name is one for numbers, not colours: .exr and .tif.
bool holds_numbers(const std::filesystem::path& path);

/// Gives the model pictures of these values (one column per channel), black where no chart is, or
/// colours at its vertices.
void put_field(const Scene& scene, const Domain& domain, const Signal& values, Depth depth,
               Model& model);

}  // namespace mq::app

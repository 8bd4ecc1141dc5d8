#pragma once
/// Texture coordinates of a remeshed surface, in the atlases of the two it was made of.

#include "mq/remesh/remesh.h"

namespace mq {

/// The mesh of `found` with texture coordinates: triangles of the template and of the target have
/// their own, in their own textures, those of the target counted from `template_textures` on. The
/// others, between the two and where long triangles were cut, show what the nearest triangle of one
/// surface shows (of the target where a corner comes from there), each corner at the nearest point
/// of it. What has no texture coordinates there has none (−1), and texture −1.
///
/// `of_template` and `target` are the meshes of the surfaces that were remeshed. Throws
/// `InvalidInput` where `found` is not of them.
Mesh textured(const Remeshed& found, const Mesh& of_template, const Mesh& target,
              int template_textures);

}  // namespace mq

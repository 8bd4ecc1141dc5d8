#pragma once
/// A model whose mesh is replaced by another's where it deviates from it: what enters `remesh`, and
/// what goes with its result, texture coordinates, pictures and colours.

#include <array>
#include <string>
#include <vector>

#include "mq/io/model.h"
#include "mq/mesh/surface.h"
#include "mq/model/messages.h"
#include "mq/remesh/remesh.h"

namespace mq {

/// The template or the target.
struct RemeshInput {
  Model model;
  Surface surface;
  CornerFrames frames = {};  ///< that its file says, of the surface's triangles

  /// What is wrong with file and surface.
  Defects defects() const;
};

/// A model that was read, as one of the two. `of_template`: the template's mesh where this is the
/// target; what of it faces the other way is turned back then, its normals with it. Remarks on what
/// the reader coped with. Throws `InvalidInput` naming the file where there are no faces, or none
/// with an area.
RemeshInput remesh_input(Model model, Messages& messages, const Mesh* of_template = nullptr);

/// Such an input again, with the pictures of another slot: read anew from its file. Without
/// pictures where its materials have none for it.
RemeshInput with_slot(const RemeshInput& input, const std::string& slot,
                      const Mesh* of_template = nullptr);

/// The slots that both have pictures for, or one of them: base colour first.
std::vector<std::string> slots_of_both(const RemeshInput& of_template, const RemeshInput& target);

/// For `RemeshOptions::rest`: the corners of the template's triangles when they were made, from a
/// model of that time. Throws `InvalidInput` where its triangles are others.
std::vector<std::array<Vector3, 3>> rest_corners(const RemeshInput& of_template,
                                                 const Model& rest_shape);

/// What goes with a remeshed mesh.
struct RemeshedContents {
  enum class Textures {
    carried,  ///< texture coordinates and pictures of both, where either has some
    left_out
  } textures = Textures::carried;
  enum class Colours {
    carried,  ///< those at vertices of both, where they have equally many channels
    origin    ///< grey where triangles of the template were kept, orange where others came
  } colours = Colours::carried;
};

/// The result but for its mesh and its colours, for `Outputs` to know names by: pictures are the
/// template's, then the target's, each under a name of its own; of one that both have there are
/// two. Throws `InvalidInput` where they are for different slots.
Model begin_remeshed(const RemeshInput& of_template, const RemeshInput& target,
                     const RemeshedContents& contents = {});

/// Gives it what `remesh` of the two surfaces found. Triangles of the two have the normals that
/// their files say, those between what is interpolated where their vertices come from; what comes
/// of a file that says none has those of the remeshed surface. So it is with materials, each of which
/// stays one. Remarks on what is left out because
/// the two do not have it alike.
void finish_remeshed(const RemeshInput& of_template, const RemeshInput& target, Remeshed found,
                     const RemeshedContents& contents, Messages& messages, Model& model);

}  // namespace mq

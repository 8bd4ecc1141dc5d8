// What was chosen, as files of labels, and what would lose it.
#include <fmt/format.h>

#include "mq/base/error.h"
#include "mq/io/image_file.h"
#include "shell/results.h"
#include "stitch_tool.h"

namespace mq::view {

/// Grey and alpha: the number of the photograph, transparent where the best is taken.
void StitchTool::write_labels(const std::vector<int>& choice, Depth depth,
                              const std::vector<std::filesystem::path>& files) const {
  std::vector<Image<float>> pictures;
  for (const TextureSize& size : session_.scene->texture_sizes)
    pictures.emplace_back(size.width, size.height, 2);
  const Texels& texels = target_->space().texels();
  const int most = depth == Depth::u16 ? 65535 : 255;
  for (int k = 0; k < texels.size(); ++k) {
    const int chosen = choice[std::size_t(k)];
    if (chosen == unseen) continue;
    const Texels::Place& at = texels.places[std::size_t(k)];
    pictures[std::size_t(at.texture)](at.x, at.y, 0) = float(chosen) / float(most);
    pictures[std::size_t(at.texture)](at.x, at.y, 1) = 1;
  }
  for (std::size_t i = 0; i < pictures.size(); ++i) write_image(files[i], pictures[i], depth);
}

void StitchTool::save_labels(const std::string& path) {
  const Outputs outputs(path, session_.scene->model, Outputs::Kind::pictures);
  for (const auto& file : outputs.paths()) {
    const std::string extension = file.extension().string();
    require(extension == ".png" || extension == ".tif" || extension == ".tiff",
            fmt::format("{}: a choice of photographs wants no loss: name a .png or a .tif", file.string()));
  }
  for (const std::string& name : options_.texts(photographs_option())) session_.run.will_read(name);
  session_.run.will_write(outputs.paths(), outputs.folders());
  const std::vector<std::filesystem::path> files = outputs.paths();
  save_behind(
      path,
      [this, files, depth = depth_of_labels(), choice = choice_now()](const Progress&) {
        write_labels(choice, depth, files);
      },
      [this, path, files, choice = choice_now()] {
        session_.say("wrote " + path);
        {
          const std::lock_guard lock(choice_mutex_);
          saved_choice_ = choice;
        }
        if (!is_saved()) return;  // others were chosen since
        std::vector<std::string> names;
        for (const auto& file : files) names.push_back(file.string());
        options_.set("labels", names);
        labels_ = names;
      });
}

void StitchTool::save() {
  const bool chosen = is_saved(), made = VerbTool::unsaved().empty();
  if (!chosen) save_labels(labels_name_);
  if (!made || chosen) VerbTool::save();
}

std::string StitchTool::unsaved() const {
  const std::string made = VerbTool::unsaved();
  if (is_saved()) return made;
  return made.empty() ? "which photograph was chosen where"
                      : "which photograph was chosen where, nor the texture made of it";
}

/// What was chosen goes with the command, saved or not.
VerbTool::Work StitchTool::saver(const OptionValues& options) {
  if (is_saved()) return VerbTool::saver(options);
  std::vector<std::filesystem::path> files;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < session_.scene->texture_sizes.size(); ++i) {
    files.push_back(folder() / fmt::format("labels{}.png", i));
    names.push_back(files.back().string());
  }
  OptionValues labelled = options;
  labelled.set("labels", names);
  return [this, files, labelled, depth = depth_of_labels(),
          choice = choice_now()](const Progress& progress) {
    write_labels(choice, depth, files);
    write(labelled, progress);
  };
}

std::string StitchTool::command_words(const OptionValues& options) const {
  require(is_saved(),
          "the command names the file of the choice, and what was chosen is not saved as it is now: save "
          "the choice first");
  return VerbTool::command_words(options);
}

/// Neither other labels nor other photographs take the place of what is not saved.
void StitchTool::require_keeps(const OptionValues& options) const {
  if (photographs_of(options) == photographs_of(options_) &&
      options.texts("labels") == options_.texts("labels"))
    return;
  require(is_saved(),
          "what was chosen would be lost, and is not saved: save the choice first, or undo it");
}

/// Other labels than those that were read or saved last take the place of what was chosen; without
/// any nothing is.
void StitchTool::before_make(const OptionValues& options) {
  if (photographs_of(options) != prepared_for_) ready_ = false;
  if (options.texts("labels") == labels_) return;
  labels_ = options.texts("labels");
  other_labels_ = true;
  ready_ = false;
  undo_.clear();
  redo_.clear();
}

}  // namespace mq::view

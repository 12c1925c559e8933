// SPDX-License-Identifier: Apache-2.0
#include <cinttypes>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/atomic_file.hpp"
#include "mapping/export_ply.hpp"
#include "mapping/map_file.hpp"
#include "mapping/top_down.hpp"
#include "procs/cli/command.hpp"

namespace cairn::cli {
namespace {

struct Options {
  std::string map;
  std::string out;
  bool json = false;
};

int info(const Options& options) {
  const auto loaded = mapping::load_map(options.map, {});
  if (!loaded) return failed(loaded.error().message);
  const mapping::VoxelMap& map = loaded->map;
  char id[17];
  std::snprintf(id, sizeof(id), "%016" PRIx64, loaded->info.map_id);
  const nlohmann::ordered_json json{{"map_id", id},
                                    {"resolution_m", map.resolution_m()},
                                    {"last_utime", loaded->info.last_utime},
                                    {"tiles", map.tile_count()},
                                    {"bricks", map.brick_count()},
                                    {"occupied_voxels", map.occupied_voxels()},
                                    {"free_voxels", map.known_voxels() - map.occupied_voxels()},
                                    {"memory_bytes", map.bytes()}};
  if (options.json) {
    std::cout << json.dump(2) << "\n";
    return 0;
  }
  for (const auto& [name, value] : json.items())
    std::printf("%-16s %s\n", name.c_str(), value.dump().c_str());
  return 0;
}

int render(const Options& options) {
  const auto loaded = mapping::load_map(options.map, {});
  if (!loaded) return failed(loaded.error().message);
  std::vector<std::uint8_t> png;
  cv::imencode(".png", mapping::render_top_down(loaded->map), png);
  const auto written = write_file_atomically(options.out, png);
  return written ? 0 : failed(written.error().message);
}

int export_points(const Options& options) {
  const auto loaded = mapping::load_map(options.map, {});
  if (!loaded) return failed(loaded.error().message);
  const auto written = mapping::export_ply(options.out, loaded->map);
  return written ? 0 : failed(written.error().message);
}

}  // namespace

void add_map(CLI::App& app, Run& run) {
  CLI::App* command = app.add_subcommand("map", "look into a map file");
  command->require_subcommand(1);
  auto options = std::make_shared<Options>();

  CLI::App* about = command->add_subcommand("info", "what it holds");
  about->add_option("map", options->map, "map file")->required();
  about->add_flag("--json", options->json, "print JSON instead of words");
  about->footer("Example:\n  cairn map info out/demo/map.cairn");
  about->callback([&run, options] { run = [options] { return info(*options); }; });

  CLI::App* picture = command->add_subcommand("render", "a picture from above");
  picture->add_option("map", options->map, "map file")->required();
  picture->add_option("--out", options->out, "PNG file")->required();
  picture->footer("Example:\n  cairn map render out/demo/map.cairn --out map.png");
  picture->callback([&run, options] { run = [options] { return render(*options); }; });

  CLI::App* points =
      command->add_subcommand("export", "its occupied voxels as a point cloud (PLY)");
  points->add_option("map", options->map, "map file")->required();
  points->add_option("--out", options->out, "PLY file")->required();
  points->footer("Example:\n  cairn map export out/demo/map.cairn --out map.ply");
  points->callback([&run, options] { run = [options] { return export_points(*options); }; });
}

}  // namespace cairn::cli

// SPDX-License-Identifier: Apache-2.0
// write_seeds FOLDER: writes the seeds of every target to FOLDER/<target>/<number>.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "fuzz/seeds.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: write_seeds FOLDER\n", stderr);
    return 2;
  }
  const std::pair<const char*, std::vector<std::string>> targets[] = {
      {"nrrd", ovoid::fuzz::nrrd_seeds()},
      {"npy", ovoid::fuzz::npy_seeds()},
      {"nifti", ovoid::fuzz::nifti_seeds()},
      {"metaimage", ovoid::fuzz::metaimage_seeds()},
      {"slc", ovoid::fuzz::slc_seeds()},
      {"slice", ovoid::fuzz::slice_seeds()},
      {"tiff", ovoid::fuzz::tiff_seeds()},
      {"zarr", ovoid::fuzz::zarr_seeds()},
      {"xdmf", ovoid::fuzz::xdmf_seeds()},
      {"netcdf", ovoid::fuzz::netcdf_seeds()},
      {"raw_name", ovoid::fuzz::raw_name_seeds()},
      {"dicom", ovoid::fuzz::dicom_seeds()},
      {"dicom_codec", ovoid::fuzz::dicom_codec_seeds()},
      {"vtk_header", ovoid::fuzz::vtk_header_seeds()},
      {"look", ovoid::fuzz::look_seeds()},
      {"look_2d", ovoid::fuzz::look_2d_seeds()},
      {"label_table", ovoid::fuzz::label_table_seeds()},
      {"plot3d", ovoid::fuzz::plot3d_seeds()},
      {"netcdf_header", ovoid::fuzz::netcdf_header_seeds()},
      {"vdb_header", ovoid::fuzz::vdb_header_seeds()},
      {"gltf", ovoid::fuzz::gltf_seeds()},
      {"picture_part", ovoid::fuzz::picture_part_seeds()},
      {"camera", ovoid::fuzz::camera_seeds()},
      {"point_text", ovoid::fuzz::point_text_seeds()},
      {"npz", ovoid::fuzz::npz_seeds()},
      {"ply", ovoid::fuzz::ply_seeds()},
      {"lammps", ovoid::fuzz::lammps_seeds()},
      {"relevant_runs", ovoid::fuzz::relevant_runs_seeds()},
  };
  for (const auto& [target, seeds] : targets) {
    const std::filesystem::path folder = std::filesystem::path(argv[1]) / target;
    std::filesystem::create_directories(folder);
    for (std::size_t i = 0; i < seeds.size(); ++i) {
      std::ofstream stream(folder / std::to_string(i), std::ios::binary);
      if (!(stream << seeds[i])) {
        std::fprintf(stderr, "%s: cannot be written\n", folder.c_str());
        return 1;
      }
    }
  }
}

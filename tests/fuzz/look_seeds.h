// SPDX-License-Identifier: Apache-2.0
// Seeds of looks, tables of labels, cameras and parts of pictures.
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "fuzz/seed_bytes.h"
#include "ovoid/io.h"

namespace ovoid::fuzz {

// Parts of pictures, as they are written: one with runs, one without.
inline std::vector<std::string> picture_part_seeds() {
  std::vector<std::string> seeds;
  for (const bool has_runs : {true, false}) {
    PicturePart part;
    part.picture = "size 3x2\n";
    part.count = 2;
    part.look.transfer_function.colors = {{0, {0, 0, 0}}, {1, {1, 1, 1}}};
    part.seen.width = 3;
    part.seen.height = 2;
    part.seen.first.assign(7, 0);
    if (has_runs) {
      part.seen.first = {0, 0, 2, 2, 3, 3, 3};
      part.seen.runs = {{-20, -3, {0.1F, 0.2F, 0.3F, 0.4F}, 3, 2.5F, 1},
                        {-3, 40, {0.5F, 0.25F, 0, 1}, 7, 6, 1},
                        {1, 2, {1, 1, 0, 1}, 1, 1, 0.5F}};
    }
    const std::filesystem::path path = std::filesystem::temp_directory_path() /
                                       ("ovoid_seed_" + std::to_string(::getpid()) + ".exr");
    write_picture_part(part, path.string());
    std::ifstream stream(path, std::ios::binary);
    seeds.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
    std::filesystem::remove(path);
  }
  return seeds;
}

// Regions, a table, ParaView's boxes, a grid of RGBA.
inline std::vector<std::string> look_2d_seeds() {
  return {
      R"({"Regions":[{"Values":[0,10],"Gradients":[0,5],"Color":[1,0,0],"Opacity":0.5,"Softness":0.25,"Foot":0.5},)"
      R"({"Shape":"Gaussian","Values":[-1,3],"Gradients":[1,2]}]})",
      R"({"Values":[0,1],"Gradients":[0,2],"Size":[2,2],"RGBA":[1,0,0,1,0,1,0,0.5,0,0,1,0.25,1,1,1,0]})",
      R"([{"Name":"a","Points":[0,0,0.5,0],"TransferFunction2D":{"Regions":[{"Values":[0,1],"Gradients":[0,1]}]}}])",
      R"(<ParaView><Proxy group="transfer_2d_functions" type="TransferFunction2D" id="2">)"
      R"(<Property name="Boxes" number_of_elements="8"><Element index="0" value="10"/>)"
      R"(<Element index="1" value="2"/><Element index="2" value="30"/><Element index="3" value="4"/>)"
      R"(<Element index="4" value="1"/><Element index="5" value="0.5"/><Element index="6" value="0"/>)"
      R"(<Element index="7" value="0.25"/></Property></Proxy></ParaView>)",
      "NRRD0004\ntype: float\ndimension: 4\nsizes: 4 2 2 1\nkinds: vector domain domain domain\n"
      "space dimension: 3\nspace directions: none (10,0,0) (0,3,0) (0,0,1)\n"
      "space origin: (5,1,0)\nencoding: ascii\n\n1 0 0 0.5 0 1 0 0.5 0 0 1 0.25 1 1 1 1\n"};
}

// Slicer's table and segmentation, ITK-SNAP's, FreeSurfer's, BIDS', and rows.
inline std::vector<std::string> label_table_seeds() {
  return {"# Color table file\n1 skin 255 128 0 255\n2 left_lung 0 0 255 128\n",
          "NRRD0004\ntype: unsigned char\ndimension: 4\nsizes: 2 1 1 1\nencoding: raw\n"
          "Segment0_LabelValue:=1\nSegment0_Layer:=0\nSegment0_Color:=1 0 0\nSegment0_Name:=a\n"
          "Segment1_LabelValue:=3\nSegment1_Layer:=1\nSegment1_Color:=0 0.5 1\n\n12",
          "    0     0    0    0        0  0  0    \"Clear Label\"\n"
          "    1   255    0    0      0.5  1  1    \"a \\ b\"\n",
          "#No. Label Name:  R G B A\n0 Unknown 0 0 0 0\n1004 ctx-lh 25 100 40 0\n",
          "index\tname\tcolor\n1\tone\t#ff0000\n2\ttwo\tn/a\n",
          "1 Precentral_L 2001\n-5 minus\n"};
}

inline std::vector<std::string> look_seeds() {
  return {
      R"([{"Name":"a","ColorSpace":"Diverging","RGBPoints":[0,0.1,0.2,0.3,0.5,1,1,1,1,0.7,0,0],"Points":[0,0,0.5,0,1,1,0.2,0.8],)"
      R"("NanColor":[1,1,0],"ScalarOpacityUnitDistance":2.5}])",
      R"([{"Name":"b","ColorSpace":"HSV","RGBPoints":[-1000,0,0,0,3000,1,1,1]},{"Name":"c","ColorSpace":"Lab","RGBPoints":[1,1,0,0,1,0,0,1]}])",
      R"({"Name":"d","ColorSpace":"Step","RGBPoints":[0,0,0,0,1,1,1,1],"Points":[]})",
      R"({"Name":"e","ColorSpace":"Lab/CIEDE2000","UseLogScale":1,"RGBPoints":[1,1,0,0,1000,0,0,1],"UseBelowRangeColor":1,"BelowRangeColor":[0,0,0]})",
      R"({"Name":"f","IndexedColors":[1,0,0,0,1,0],"Annotations":["0","a","7","b"],"Points":[0,0,0.5,0]})",
      R"({"Points":[-5,0,0.5,0,5,1,0.5,0],"SymlogLinearWidth":0.1,"GradientOpacityPoints":[0,0,0.5,0,9,1,0.5,0],"Shade":false,"Ambient":0.3,"Lights":[{"Direction":[1,0,-2],"Intensity":0.4},{"Direction":[0,1,0]}]})",
      R"({"@schema":"s","volumeProperties":[{"components":[{"shade":true,"lighting":{"ambient":0.2,"specularPower":5},)"
      R"("rgbTransferFunction":{"points":[{"x":0,"color":[0,0,0],"midpoint":0.3,"sharpness":0.5},{"x":9,"color":[1,1,1]}]},)"
      R"("scalarOpacity":{"points":[{"x":0,"y":0},{"x":9,"y":1}]},"gradientOpacity":{"points":[{"x":0,"y":0}]},"scalarOpacityUnitDistance":1}]}]})",
      "1\n1\n0.9\n0.1\n0.2\n10\n4 -100 0 300 0.75\n4 0 0 255 1\n8 -100 0 0 0 300 1 0.5 0.25\n",
      "<ColorMaps><ColorMap name=\"a&amp;b\" space=\"Lab\"><Point x=\"0\" o=\"0.5\" r=\"1\" "
      "g=\"0\" b=\"0\"/>"
      "<Point x=\"1\" o=\"1\" r=\"0\" g=\"0\" b=\"1\"/><NaN r=\"0\" g=\"0\" "
      "b=\"0\"/></ColorMap></ColorMaps>",
      "<ColorMap indexedLookup=\"1\" space=\"Lab/CIEDE2000\"><Point x='0' r='1' g='0' "
      "b='0'/></ColorMap>",
      "<MRML><VolumeProperty name=\"p\" shade=\"1\" ambient=\"0.1\" scalarOpacity=\"4 0 0 9 1\" "
      "gradientOpacity=\"4 0 0 9 1\" colorTransfer=\"4 0 1 0 0\"/></MRML>",
      "<InviwoWorkspace><Points><Point><pos content=\"0\"/><rgba x=\"1\" y=\"0\" z=\"0\" "
      "w=\"0.5\"/></Point></Points></InviwoWorkspace>",
      "# rows\n0 0.25 #ff8000\n10 1 #0000ff\n",
      "0,0,0,0,0.5,1,0,0,1,1,1,1",
      "0 0\n0.5 1\n1 0\n",
      "0 1 0 0 0.25\n1 0 1 0 0.75\n",
  };
}

inline std::vector<std::string> camera_seeds() {
  return {
      R"({"position":[0,0,5],"focal_point":[0,0,0],"view_up":[0,1,0],"parallel_projection":true,"parallel_scale":2,"view_angle":30})",
      R"({"position":[1e6,-2.5,3],"view_angle":45.5})",
  };
}

}  // namespace ovoid::fuzz

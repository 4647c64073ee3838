// SPDX-License-Identifier: Apache-2.0
// The published bilinear spread: a lattice's sample is shared among the four nodes around it
// (docs/numerics.md, "Spread"). Here a node looks for the samples that it has a share of.

// `node_step`: pixels from node to node.
Gathered spread_at(Place place, float s, float node_step) {
  LatticeConstants lattice = frame.fields[0];
  float apart = (frame.view.pitch + s * frame.view.pitch_per_sheet) * node_step;
  float tau = lattice.sigma * length(lattice.camera_rows[2].xyz);
  vec3 reach = vec3(apart, apart, lattice.support / lattice.sigma * tau);
  float sum = 0.0, weights = 0.0;
  bool is_whole = true;
  for (int n = 0; n < num_sublattices(0); ++n) {
    Place own = in_sublattice(place, offset_of(lattice, n));
    vec3 index_reach =
        vec3(dot(lattice.camera_columns[0].xyz, reach), dot(lattice.camera_columns[1].xyz, reach),
             dot(lattice.camera_columns[2].xyz, reach));
    ivec3 lo = ivec3(ceil(own.fraction - index_reach));
    ivec3 hi = ivec3(floor(own.fraction + index_reach));
    for (int k = lo.z; k <= hi.z; ++k) {
      for (int j = lo.y; j <= hi.y; ++j) {
        for (int i = lo.x; i <= hi.x; ++i) {
          vec3 offset = vec3(i, j, k) - own.fraction;
          float a = abs(dot(lattice.camera_rows[0].xyz, offset)) / apart;
          float b = abs(dot(lattice.camera_rows[1].xyz, offset)) / apart;
          float c = dot(lattice.camera_rows[2].xyz, offset) / tau;
          if (a > 1.0 || b > 1.0 || abs(c) > lattice.support / lattice.sigma) continue;
          float weight = (1.0 - a) * (1.0 - b) * exp(-0.5 * c * c);
          if (!(weight > 0.0)) continue;
          ivec3 at = own.cell + ivec3(i, j, k);
          if (any(lessThan(at, ivec3(0))) ||
              any(greaterThanEqual(at, dims_of(lattice, n)))) {
            is_whole = false;
            continue;
          }
          float number = sample_at(0, row_at(0, n, at.y, at.z), at.x);
          if (is_missing(number) && kType0 == kTypeF32) {
            is_whole = false;
            continue;
          }
          sum = fma(weight, fma(number, lattice.value_scale, lattice.value_offset), sum);
          weights += weight;
        }
      }
    }
  }
  Gathered result;
  result.gradient = vec3(0.0);
  result.is_defined = is_whole && weights > 0.0;
  result.value = result.is_defined ? sum / weights : 0.0;
  return result;
}

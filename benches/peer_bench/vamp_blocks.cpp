// Blocks of eight postures of a Panda among things, as VAMP checks them: reads numbers, prints
// whether each block is free, and the time of a posture of the whole of each case.
//
// Input, as doubles, case after case until the end: counts of spheres, capsules, boxes and blocks;
// spheres (x, y, z, r); capsules (two ends, r); boxes (centre, half lengths, axes); eight
// postures a block.
#include <vamp/collision/environment.hh>
#include <vamp/collision/factory.hh>
#include <vamp/robots/panda.hh>
#include <vamp/vector.hh>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

using Robot = vamp::robots::Panda;
static constexpr std::size_t rake = vamp::FloatVectorWidth;
using Lanes = vamp::FloatVector<rake>;
using Block = Robot::ConfigurationBlock<rake>;

static double now() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}

// Not part of the loop that times it, or it would be moved out of it.
[[gnu::noinline]] static bool is_free(const vamp::collision::Environment<Lanes> &things,
                                      const Block &block) {
  return Robot::template fkcc<rake>(things, block);
}

int main(int, char **argv) {
  static_assert(rake == 8);
  std::FILE *file = std::fopen(argv[1], "rb");
  int repeats = std::atoi(argv[2]);
  if (!file) return 1;
  auto take = [&](std::size_t count) {
    std::vector<double> values(count);
    if (std::fread(values.data(), sizeof(double), count, file) != count) std::exit(1);
    return values;
  };
  double head[4];
  while (std::fread(head, sizeof(double), 4, file) == 4) {
    auto spheres = take(4 * head[0]), capsules = take(7 * head[1]), boxes = take(15 * head[2]);
    auto postures = take(56 * head[3]);
    vamp::collision::Environment<float> plain;
    for (std::size_t i = 0; i < head[0]; ++i) {
      const double *s = &spheres[4 * i];
      plain.spheres.emplace_back(vamp::collision::factory::sphere::flat(s[0], s[1], s[2], s[3]));
    }
    for (std::size_t i = 0; i < head[1]; ++i) {
      const double *c = &capsules[7 * i];
      plain.capsules.emplace_back(vamp::collision::factory::capsule::endpoints::flat(
          c[0], c[1], c[2], c[3], c[4], c[5], c[6]));
    }
    for (std::size_t i = 0; i < head[2]; ++i) {
      const double *b = &boxes[15 * i];
      plain.cuboids.emplace_back(vamp::collision::Cuboid<float>(b[0], b[1], b[2], b[6], b[7], b[8],
          b[9], b[10], b[11], b[12], b[13], b[14], b[3], b[4], b[5]));
    }
    plain.sort();
    vamp::collision::Environment<Lanes> things(plain);
    std::vector<Block> blocks(head[3]);
    for (std::size_t b = 0; b < blocks.size(); ++b)
      for (std::size_t j = 0; j < 7; ++j) {
        alignas(64) float row[rake];
        for (std::size_t k = 0; k < rake; ++k) row[k] = postures[56 * b + 7 * k + j];
        blocks[b][j] = Lanes(row);
      }
    std::vector<int> free(blocks.size());
    double best = 1e300;
    for (int repeat = 0; repeat < repeats; ++repeat) {
      double start = now();
      for (std::size_t b = 0; b < blocks.size(); ++b) free[b] = is_free(things, blocks[b]);
      double took = now() - start;
      if (took < best) best = took;
    }
    std::printf("%.17g", best / (8.0 * blocks.size()));
    for (int f : free) std::printf(" %d", f);
    std::printf("\n");
  }
}

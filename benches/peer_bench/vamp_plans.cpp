// VAMP's RRT-Connect on problems of a Panda: reads numbers, prints for each problem whether start
// and goal are free, whether it is solved, and the least CPU time of some repeats, ns.
//
// Input, as doubles, problem after problem until the end: counts of spheres, capsules and boxes;
// spheres (x, y, z, r); capsules (two ends, r); boxes (centre, half lengths, axes); start; goal.
#include <vamp/collision/environment.hh>
#include <vamp/collision/factory.hh>
#include <vamp/planning/rrtc.hh>
#include <vamp/planning/validate.hh>
#include <vamp/random/halton.hh>
#include <vamp/robots/panda.hh>
#include <vamp/vector.hh>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <vector>

using Robot = vamp::robots::Panda;
static constexpr std::size_t rake = vamp::FloatVectorWidth;
using Lanes = vamp::FloatVector<rake>;
using Planner = vamp::planning::RRTC<Robot, rake, Robot::resolution>;

static double now() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}

int main(int, char **argv) {
  std::FILE *file = std::fopen(argv[1], "rb");
  int repeats = std::atoi(argv[2]);
  if (!file) return 1;
  vamp::planning::RRTCSettings settings;
  settings.range = 1.0;  // what VAMP has for this arm
  // Its Python default allocates 10^6 nodes a call, which takes most of the time.
  settings.max_iterations = settings.max_samples = std::atoi(argv[3]);
  auto take = [&](std::size_t count) {
    std::vector<double> values(count);
    if (std::fread(values.data(), sizeof(double), count, file) != count) std::exit(1);
    return values;
  };
  auto posture = [&]() {
    auto row = take(7);
    Robot::ConfigurationArray values;
    for (std::size_t j = 0; j < 7; ++j) values[j] = row[j];
    return Robot::Configuration(values);
  };
  double head[3];
  while (std::fread(head, sizeof(double), 3, file) == 3) {
    auto spheres = take(4 * head[0]), capsules = take(7 * head[1]), boxes = take(15 * head[2]);
    auto start = posture(), goal = posture();
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
    auto is_free = [&](const Robot::Configuration &q) {
      return vamp::planning::validate_motion<Robot, rake, 1>(q, q, things);
    };
    bool valid = is_free(start) && is_free(goal), solved = false;
    double best = 1e300;
    for (int repeat = 0; valid && repeat < repeats; ++repeat) {
      auto random = std::make_shared<vamp::rng::Halton<Robot>>();
      double begin = now();
      auto found = Planner::solve(start, goal, things, settings, random);
      double took = now() - begin;
      solved = found.path.size() > 0;
      if (took < best) best = took;
    }
    std::printf("%d %d %.17g\n", int(valid), int(solved), valid ? 1e9 * best : 0.0);
  }
}

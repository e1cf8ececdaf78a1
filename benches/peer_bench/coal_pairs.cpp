// All pairs of boxes and spheres by coal, and hits with its tree: reads numbers, prints times.
//
// Input, as doubles: count of postures, of boxes, of spheres; half lengths of the boxes; spheres
// (x, y, z, r); of each posture and box a pose of 12 numbers, row by row.
#include <coal/broadphase/broadphase_dynamic_AABB_tree.h>
#include <coal/broadphase/default_broadphase_callbacks.h>
#include <coal/collision.h>
#include <coal/distance.h>
#include <coal/shape/geometric_shapes.h>

#include <cstdio>
#include <ctime>
#include <memory>
#include <vector>

static double now() {
  timespec t;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}

int main(int, char **argv) {
  std::FILE *file = std::fopen(argv[1], "rb");
  if (!file) return 1;
  auto take = [&](size_t count) {
    std::vector<double> values(count);
    if (std::fread(values.data(), sizeof(double), count, file) != count) std::exit(1);
    return values;
  };
  auto head = take(3);
  size_t postures = head[0], boxes = head[1], spheres = head[2];
  auto half = take(3 * boxes), cloud = take(4 * spheres), poses = take(12 * postures * boxes);

  std::vector<coal::Box> shapes;
  for (size_t b = 0; b < boxes; ++b)
    shapes.emplace_back(2 * half[3 * b], 2 * half[3 * b + 1], 2 * half[3 * b + 2]);
  std::vector<coal::Sphere> points;
  std::vector<coal::Transform3s> places;
  std::vector<std::unique_ptr<coal::CollisionObject>> objects;
  coal::DynamicAABBTreeCollisionManager manager;
  for (size_t s = 0; s < spheres; ++s) {
    const double *row = &cloud[4 * s];
    points.emplace_back(row[3]);
    coal::Transform3s at;
    at.setTranslation(coal::Vec3s(row[0], row[1], row[2]));
    places.push_back(at);
    objects.push_back(std::make_unique<coal::CollisionObject>(
        std::make_shared<coal::Sphere>(row[3]), at));
    manager.registerObject(objects.back().get());
  }
  manager.setup();
  auto pose = [&](size_t posture, size_t box) {
    const double *m = &poses[12 * (posture * boxes + box)];
    coal::Matrix3s turn;
    turn << m[0], m[1], m[2], m[4], m[5], m[6], m[8], m[9], m[10];
    return coal::Transform3s(turn, coal::Vec3s(m[3], m[7], m[11]));
  };

  std::vector<double> least(postures, 1e300);
  double start = now();
  for (size_t p = 0; p < postures; ++p)
    for (size_t b = 0; b < boxes; ++b) {
      auto at = pose(p, b);
      for (size_t s = 0; s < spheres; ++s) {
        coal::DistanceRequest request;
        coal::DistanceResult result;
        double away = coal::distance(&shapes[b], at, &points[s], places[s], request, result);
        if (away < least[p]) least[p] = away;
      }
    }
  double pairs = (now() - start) / postures;
  std::vector<bool> hits(postures);
  start = now();
  for (size_t p = 0; p < postures; ++p) {
    bool hit = false;
    for (size_t b = 0; b < boxes && !hit; ++b) {
      coal::CollisionObject body(std::make_shared<coal::Box>(shapes[b]), pose(p, b));
      coal::CollisionCallBackDefault callback;
      manager.collide(&body, &callback);
      hit = callback.data.result.isCollision();
    }
    hits[p] = hit;
  }
  double tree = (now() - start) / postures;
  std::printf("%.17g %.17g\n", pairs, tree);
  for (size_t p = 0; p < postures; ++p) std::printf("%.17g %d\n", least[p], int(hits[p]));
}

#pragma once
/// Embree 3 or 4, whichever the build found: all that differs between them for us is here. Included by
/// sources, never by headers. (Tested with 3.13 of Debian 12; with 4.3.3 it compiles, no test has run.)

#if MARQUETRY_EMBREE >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace mq {

/// Finds the first hit of a ray, one of many beside each other.
inline void find_hit(RTCScene scene, RTCRayHit& query) {
#if MARQUETRY_EMBREE >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect1(scene, &query, &arguments);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect1(scene, &context, &query);
#endif
}

/// Whether a ray hits anything.
inline bool is_blocked(RTCScene scene, RTCRay& ray) {
#if MARQUETRY_EMBREE >= 4
  rtcOccluded1(scene, &ray, nullptr);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &ray);
#endif
  return ray.tfar < 0;
}

}  // namespace mq

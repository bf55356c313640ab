/* SPDX-License-Identifier: Apache-2.0
 * Copyright the edgefusion authors
 *
 * Loaded before the C library (LD_PRELOAD), it moves the wall clock of one process alone: by as many nanoseconds as
 * the file that WALL_CLOCK_FILE names holds at the time. The monotonic clock is left as it is. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <semaphore.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

typedef int (*gettime_t)(clockid_t, struct timespec *);
static gettime_t real_gettime;
static const volatile int64_t *offset_ns;
static const int64_t SECOND_NS = 1000000000;

static void __attribute__((constructor)) begin(void) {
  const char *name = getenv("WALL_CLOCK_FILE");
  int file = name ? open(name, O_RDONLY | O_CLOEXEC) : -1;
  real_gettime = (gettime_t)dlsym(RTLD_NEXT, "clock_gettime");
  if (file < 0) return;
  void *page = mmap(NULL, sizeof *offset_ns, PROT_READ, MAP_SHARED, file, 0);
  close(file);
  if (page != MAP_FAILED) offset_ns = page;
}

int clock_gettime(clockid_t clock, struct timespec *now) {
  if (!real_gettime) real_gettime = (gettime_t)dlsym(RTLD_NEXT, "clock_gettime");
  int failed = real_gettime(clock, now);
  if (failed || !offset_ns || (clock != CLOCK_REALTIME && clock != CLOCK_REALTIME_COARSE)) return failed;
  int64_t ns = now->tv_nsec + *offset_ns % SECOND_NS;
  now->tv_sec += *offset_ns / SECOND_NS + (ns < 0 ? -1 : ns / SECOND_NS);
  now->tv_nsec = (ns + SECOND_NS) % SECOND_NS;
  return 0;
}

int gettimeofday(struct timeval *restrict now, void *restrict zone) {
  struct timespec fine;
  (void)zone;
  if (clock_gettime(CLOCK_REALTIME, &fine)) return -1;
  now->tv_sec = fine.tv_sec;
  now->tv_usec = fine.tv_nsec / 1000;
  return 0;
}

time_t time(time_t *out) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  if (out) *out = now.tv_sec;
  return now.tv_sec;
}

/* The kernel would go by its own wall clock: a lock's timeout in Python before 3.11. */
int sem_timedwait(sem_t *restrict semaphore, const struct timespec *restrict until) {
  struct timespec now, nap = {0, 1000000};
  while (sem_trywait(semaphore)) {
    if (errno != EAGAIN) return -1;
    clock_gettime(CLOCK_REALTIME, &now);
    if (now.tv_sec > until->tv_sec || (now.tv_sec == until->tv_sec && now.tv_nsec >= until->tv_nsec)) {
      errno = ETIMEDOUT;
      return -1;
    }
    nanosleep(&nap, NULL);
  }
  return 0;
}

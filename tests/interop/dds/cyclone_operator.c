/* A stranger who operates a running gateway: hears every topic that it and the simulator publish, engages it,
 * moves the load's reference, sees the load follow, and settles it. Usage: cyclone_operator DOMAIN. Each step
 * has 40 s; the exit code says whether all were done. A machine that stands still makes the gateway let go
 * and latch, rightly: then he resets it and begins again, twice at most. */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "Estimate.h"
#include "Mode.h"
#include "ModeRequest.h"
#include "Reference.h"
#include "cyclone_topics.h"

static dds_entity_t mode_reader, estimate_reader, request_writer, reference_writer;
static motionlab_ModeState state = motionlab_MODE_OFF;
static double load[3];
static double wanted[3];
static char fault_code[33];

static void look(void) {
  void* sample = NULL;
  dds_sample_info_t info;
  while (dds_take(mode_reader, &sample, &info, 1, 1) == 1) {
    if (info.valid_data) {
      const motionlab_Mode* const mode = sample;
      state = mode->state;
      snprintf(fault_code, sizeof fault_code, "%s", mode->fault_code);
    }
    dds_return_loan(mode_reader, &sample, 1);
    sample = NULL;
  }
  while (dds_take(estimate_reader, &sample, &info, 1, 1) == 1) {
    if (info.valid_data) memcpy(load, ((const motionlab_Estimate*)sample)->p_world_load_m, sizeof load);
    dds_return_loan(estimate_reader, &sample, 1);
    sample = NULL;
  }
}

static void ask(motionlab_ModeAction action) {
  static uint64_t asked;
  motionlab_ModeRequest request;
  memset(&request, 0, sizeof request);
  strcpy(request.requester, "stranger");
  request.sequence_number = ++asked;
  request.t_created_ns = dds_time();
  request.action = action;
  checked(dds_write(request_writer, &request), "motionlab/mode_request");
}

static void refer(void) {
  static uint64_t referred;
  motionlab_Reference reference;
  memset(&reference, 0, sizeof reference);
  strcpy(reference.requester, "stranger");
  reference.sequence_number = ++referred;
  reference.t_created_ns = dds_time();
  memcpy(reference.p_world_load_m, wanted, sizeof wanted);
  checked(dds_write(reference_writer, &reference), "motionlab/reference");
}

static bool there(void) {
  return hypot(hypot(load[0] - wanted[0], load[1] - wanted[1]), load[2] - wanted[2]) < 0.02;
}
static bool is_ready(void) {
  return state == motionlab_MODE_READY;
}
static bool is_engaged(void) {
  return state == motionlab_MODE_ENGAGED;
}
static bool is_over(void) {
  return state == motionlab_MODE_SETTLED || state == motionlab_MODE_READY;
}
static bool is_fault(void) {
  return state == motionlab_MODE_FAULT;
}
static void nothing(void) {}
static void engage(void) {
  ask(motionlab_ACTION_ENGAGE);
}
static void settle(void) {
  ask(motionlab_ACTION_SETTLE);
}
static void reset(void) {
  ask(motionlab_ACTION_RESET);
}

/* Does it every half second until it is so. False when the gateway has let go meanwhile. */
static bool until(bool (*done)(void), void (*act)(void), const char* what) {
  const dds_time_t end = dds_time() + DDS_SECS(40);
  dds_time_t next = 0;
  for (look(); !done(); look()) {
    if (dds_time() > end) {
      fprintf(stderr, "cyclone: not %s; mode %d, load %.3f %.3f %.3f\n", what, (int)state, load[0], load[1],
              load[2]);
      exit(1);
    }
    if (is_fault() && act != reset) {
      printf("let go: %s\n", fault_code);
      return false;
    }
    if (dds_time() >= next) {
      act();
      next = dds_time() + DDS_MSECS(500);
    }
    dds_sleepfor(DDS_MSECS(5));
  }
  printf("%s\n", what);
  fflush(stdout);
  return true;
}

/* What the gateway and the simulator publish; the score and the two topics that only come in are not among
 * it. */
static void hear_every_topic(dds_entity_t participant) {
  const dds_time_t end = dds_time() + DDS_SECS(40);
  for (size_t i = 0; i < topic_count; ++i) {
    const struct topic* topic = &every_topic[i];
    if (topic->class == TOPIC_REQUEST || strcmp(topic->name, "motionlab/reference") == 0 ||
        strcmp(topic->name, "motionlab/score") == 0) {
      continue;
    }
    const dds_entity_t reader = reader_of(participant, topic);
    void* sample = NULL;
    dds_sample_info_t info = {.valid_data = false};
    while (dds_take(reader, &sample, &info, 1, 1) != 1 || !info.valid_data) {
      refuse_incompatible_reader(reader, topic->name);
      if (dds_time() > end) {
        fprintf(stderr, "cyclone: heard nothing of %s\n", topic->name);
        exit(1);
      }
      if (sample) dds_return_loan(reader, &sample, 1);
      sample = NULL;
      dds_sleepfor(DDS_MSECS(5));
    }
    dds_return_loan(reader, &sample, 1);
    printf("heard %s\n", topic->name);
    fflush(stdout);
  }
}

static bool operate(dds_entity_t participant) {
  if (!until(is_engaged, engage, "engaged")) return false;
  hear_every_topic(participant);
  look();
  memcpy(wanted, load, sizeof wanted);
  wanted[1] += 0.10;
  wanted[2] -= 0.05;
  return until(there, refer, "moved") && until(is_over, settle, "settled");
}

int main(int argc, char** argv) {
  if (argc != 2) return 64;
  const dds_entity_t participant = participant_of((dds_domainid_t)strtoul(argv[1], NULL, 10));
  mode_reader = reader_of(participant, topic_named("motionlab/mode"));
  estimate_reader = reader_of(participant, topic_named("motionlab/estimate"));
  request_writer = writer_of(participant, topic_named("motionlab/mode_request"));
  reference_writer = writer_of(participant, topic_named("motionlab/reference"));

  until(is_ready, nothing, "ready");
  bool done = operate(participant);
  for (int again = 0; again < 2 && !done; ++again) {
    until(is_ready, reset, "reset");
    done = operate(participant);
  }
  dds_delete(participant);
  return done ? 0 : 1;
}

/* Reads motionlab/mru and motionlab/estimate with Cyclone DDS and prints one line per sample, all fields,
 * doubles as hexadecimal. Usage: cyclone_subscriber DOMAIN COUNT. Ends well when COUNT samples of each were
 * read; fails after a minute, and at once when Cyclone reports an incompatible quality of service. */
#include <inttypes.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

#include "Estimate.h"
#include "Mru.h"
#include "dds/dds.h"

static void print_doubles(const char* name, const double* values, size_t count) {
  printf(" %s=", name);
  for (size_t i = 0; i < count; ++i) printf("%s%a", i == 0 ? "" : ",", values[i]);
}

#define PRINT_ARRAY(s, name) print_doubles(#name, (s)->name, sizeof((s)->name) / sizeof((s)->name[0]))
#define PRINT_DOUBLE(s, name) print_doubles(#name, &(s)->name, 1)

static void print_mru(const motionlab_Mru* s) {
  printf("mru device=%s sequence_number=%" PRIu64, s->device, s->sequence_number);
  printf(" t_measured_ns=%" PRId64 " t_received_ns=%" PRId64, s->t_measured_ns, s->t_received_ns);
  printf(" stable=%d checksum_suspect=%d", s->stable, s->checksum_suspect);
  PRINT_ARRAY(s, euler_heading_mru_rad);
  PRINT_ARRAY(s, omega_mru_radps);
  PRINT_DOUBLE(s, omega_down_radps);
  PRINT_ARRAY(s, v_mru_mps);
  PRINT_ARRAY(s, a_mru_mps2);
  PRINT_ARRAY(s, p_heading_origin_m);
  PRINT_ARRAY(s, v_heading_origin_mps);
  PRINT_ARRAY(s, a_heading_origin_mps2);
  PRINT_DOUBLE(s, sensor_temperature_degc);
  printf("\n");
}

static void print_estimate(const motionlab_Estimate* s) {
  printf("estimate sequence_number=%" PRIu64 " t_estimated_ns=%" PRId64, s->sequence_number,
         s->t_estimated_ns);
  printf(" valid=%d platform_tracked=%d load_tracked=%d", s->valid, s->platform_tracked, s->load_tracked);
  PRINT_ARRAY(s, p_world_platform_m);
  PRINT_ARRAY(s, q_world_platform);
  PRINT_DOUBLE(s, wire_length_m);
  PRINT_ARRAY(s, swing_rad);
  PRINT_ARRAY(s, p_world_load_m);
  PRINT_ARRAY(s, p_world_load_sd_m);
  printf("\n");
}

static dds_entity_t checked(dds_entity_t entity, const char* what) {
  if (entity < 0) {
    fprintf(stderr, "cyclone: %s: %s\n", what, dds_strretcode(-entity));
    exit(2);
  }
  return entity;
}

static void refuse_incompatible(dds_entity_t reader, const char* topic) {
  dds_requested_incompatible_qos_status_t status;
  if (dds_get_requested_incompatible_qos_status(reader, &status) == DDS_RETCODE_OK &&
      status.total_count > 0) {
    fprintf(stderr, "cyclone: %s: incompatible quality of service, policy %" PRIu32 "\n", topic,
            status.last_policy_id);
    exit(3);
  }
}

int main(int argc, char** argv) {
  if (argc != 3) return 64;
  const long count = strtol(argv[2], NULL, 10);
  const dds_entity_t participant =
      checked(dds_create_participant((dds_domainid_t)strtoul(argv[1], NULL, 10), NULL, NULL), "participant");
  const dds_entity_t mru_topic = checked(
      dds_create_topic(participant, &motionlab_Mru_desc, "motionlab/mru", NULL, NULL), "topic motionlab/mru");
  const dds_entity_t estimate_topic =
      checked(dds_create_topic(participant, &motionlab_Estimate_desc, "motionlab/estimate", NULL, NULL),
              "topic motionlab/estimate");
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 16);
  const dds_entity_t mru =
      checked(dds_create_reader(participant, mru_topic, qos, NULL), "reader motionlab/mru");
  const dds_entity_t estimate =
      checked(dds_create_reader(participant, estimate_topic, qos, NULL), "reader motionlab/estimate");
  dds_delete_qos(qos);

  long seen_mru = 0;
  long seen_estimate = 0;
  const dds_time_t end = dds_time() + DDS_SECS(60);
  while (seen_mru < count || seen_estimate < count) {
    if (dds_time() > end) {
      fprintf(stderr, "cyclone: got %ld of motionlab/mru and %ld of motionlab/estimate, not %ld each\n",
              seen_mru, seen_estimate, count);
      return 1;
    }
    refuse_incompatible(mru, "motionlab/mru");
    refuse_incompatible(estimate, "motionlab/estimate");
    void* sample = NULL;
    dds_sample_info_t info;
    while (dds_take(mru, &sample, &info, 1, 1) == 1) {
      if (info.valid_data && seen_mru++ < count) print_mru(sample);
      dds_return_loan(mru, &sample, 1);
      sample = NULL;
    }
    while (dds_take(estimate, &sample, &info, 1, 1) == 1) {
      if (info.valid_data && seen_estimate++ < count) print_estimate(sample);
      dds_return_loan(estimate, &sample, 1);
      sample = NULL;
    }
    dds_sleepfor(DDS_MSECS(2));
  }
  dds_delete(participant);
  return 0;
}

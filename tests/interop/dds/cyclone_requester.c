/* Writes COUNT requests to motionlab/mode_request with Cyclone DDS, once a reader matches.
 * Usage: cyclone_requester DOMAIN COUNT REQUESTER. Stays until its reader has left or a minute is over. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ModeRequest.h"
#include "dds/dds.h"

static dds_entity_t checked(dds_entity_t entity, const char* what) {
  if (entity < 0) {
    fprintf(stderr, "cyclone: %s: %s\n", what, dds_strretcode(-entity));
    exit(2);
  }
  return entity;
}

static unsigned readers(dds_entity_t writer) {
  dds_publication_matched_status_t matched;
  dds_offered_incompatible_qos_status_t refused;
  if (dds_get_offered_incompatible_qos_status(writer, &refused) == DDS_RETCODE_OK &&
      refused.total_count > 0) {
    fprintf(stderr, "cyclone: motionlab/mode_request: incompatible quality of service, policy %u\n",
            (unsigned)refused.last_policy_id);
    exit(3);
  }
  return dds_get_publication_matched_status(writer, &matched) == DDS_RETCODE_OK ? matched.current_count : 0;
}

int main(int argc, char** argv) {
  if (argc != 4) return 64;
  const dds_entity_t participant =
      checked(dds_create_participant((dds_domainid_t)strtoul(argv[1], NULL, 10), NULL, NULL), "participant");
  const dds_entity_t topic = checked(
      dds_create_topic(participant, &motionlab_ModeRequest_desc, "motionlab/mode_request", NULL, NULL),
      "topic");
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 16);
  const dds_entity_t writer = checked(dds_create_writer(participant, topic, qos, NULL), "writer");
  dds_delete_qos(qos);

  const dds_time_t end = dds_time() + DDS_SECS(60);
  while (readers(writer) == 0) {
    if (dds_time() > end) {
      fprintf(stderr, "cyclone: nobody reads motionlab/mode_request\n");
      return 1;
    }
    dds_sleepfor(DDS_MSECS(5));
  }
  /* The match is one-sided for a moment; a requester of the house repeats, this one gives the reader a pause.
   */
  dds_sleepfor(DDS_MSECS(500));
  const long count = strtol(argv[2], NULL, 10);
  motionlab_ModeRequest request;
  memset(&request, 0, sizeof request);
  strncpy(request.requester, argv[3], sizeof request.requester - 1);
  for (long n = 1; n <= count; ++n) {
    request.sequence_number = (uint64_t)n;
    request.t_created_ns = -1000000007L * n;
    request.action = n % 2 ? motionlab_ACTION_ENGAGE : motionlab_ACTION_AUTHORITY;
    request.authority = motionlab_AUTHORITY_LIMITED;
    const dds_return_t written = dds_write(writer, &request);
    if (written != DDS_RETCODE_OK) {
      fprintf(stderr, "cyclone: write: %s\n", dds_strretcode(-written));
      return 2;
    }
  }
  while (readers(writer) > 0 && dds_time() < end) dds_sleepfor(DDS_MSECS(5));
  dds_delete(participant);
  return 0;
}

/* A stranger who writes what the house does not expect: `stranger/fish`, whose type is unknown, and
 * `stranger/mru` with a type of the house, whose device is called by an escape sequence. Best effort, a
 * hundred times a second, of the second topic every tenth sequence number left out. Usage: cyclone_stranger
 * DOMAIN; until it is killed, or for five minutes. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "Fish.h"
#include "Mru.h"
#include "dds/dds.h"

static dds_entity_t checked(dds_entity_t entity, const char* what) {
  if (entity < 0) {
    fprintf(stderr, "cyclone: %s: %s\n", what, dds_strretcode(-entity));
    exit(2);
  }
  return entity;
}

static dds_entity_t writer_of(dds_entity_t participant, const dds_topic_descriptor_t* type,
                              const char* name) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1);
  const dds_entity_t topic = checked(dds_create_topic(participant, type, name, NULL, NULL), name);
  const dds_entity_t writer = checked(dds_create_writer(participant, topic, qos, NULL), name);
  dds_delete_qos(qos);
  return writer;
}

int main(int argc, char** argv) {
  if (argc != 2) return 64;
  dds_qos_t* qos = dds_create_qos();
  dds_qset_entity_name(qos, "stranger");
  const dds_entity_t participant =
      checked(dds_create_participant((dds_domainid_t)strtoul(argv[1], NULL, 10), qos, NULL), "participant");
  dds_delete_qos(qos);
  const dds_entity_t fishes = writer_of(participant, &stranger_Fish_desc, "stranger/fish");
  const dds_entity_t mrus = writer_of(participant, &motionlab_Mru_desc, "stranger/mru");

  stranger_Fish fish;
  memset(&fish, 0, sizeof fish);
  strcpy(fish.name, "cod");
  motionlab_Mru mru;
  memset(&mru, 0, sizeof mru);
  strcpy(mru.device, "\033[2Jevil");
  for (int i = 0; i < 30000; ++i) {
    checked(dds_write(fishes, &fish), "stranger/fish");
    mru.sequence_number += mru.sequence_number % 10 == 9 ? 2 : 1;
    mru.t_measured_ns = (int64_t)mru.sequence_number * 10000000; /* its own time: exactly 100 Hz */
    mru.t_received_ns = mru.t_measured_ns + 2000000;
    checked(dds_write(mrus, &mru), "stranger/mru");
    dds_sleepfor(DDS_MSECS(10));
  }
  dds_delete(participant);
  return 0;
}

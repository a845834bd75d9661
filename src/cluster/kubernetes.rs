//! The manifest for Kubernetes: an Indexed Job with a pod for each shard, and the merge as a Job that waits
//! to be started. Kubernetes itself replaces pods that are stopped or fail.

use super::{Job, NOTICE_S, VisibleWord};

/// Where the pods run and what they see.
#[derive(Clone, Debug)]
pub(crate) struct Pods {
    /// The container image.
    pub(crate) image: VisibleWord,
    /// The volume claim that holds the study and takes the results; all pods write to it.
    pub(crate) claim: VisibleWord,
    /// Where the volume is mounted; relative paths start there.
    pub(crate) mount: VisibleWord,
    /// How many pods run at a time; all shards without.
    pub(crate) parallelism: Option<u32>,
}

/// The manifest, two documents of YAML.
pub(crate) fn manifest(job: &Job, pods: &Pods) -> String {
    let Job { name, study, out, shards, tries, .. } = job;
    let parallelism = pods.parallelism.unwrap_or(*shards);
    let mount = &pods.mount;
    format!(
        r#"# Sweeps {study} in {shards} shards on Kubernetes (1.29 or later) and merges them into {out}, both in {mount}.
#   kubectl apply -f FILE
#   kubectl wait --for=condition=complete --timeout=-1s job/{name}
#   kubectl patch job/{name}-merge --type=merge -p '{{"spec":{{"suspend":false}}}}'
#   kubectl wait --for=condition=complete --timeout=-1s job/{name}-merge
# The first Job has a pod for each shard; a pod that is stopped or fails is replaced by one that goes on where it was. The
# second merges (kubectl logs job/{name}-merge names what is missing) and is started by hand, as Jobs cannot wait for Jobs.
# Add what your cluster wants (namespace, GPUs, tolerations); the commands and the number of completions belong together.
# To go on with what is missing: kubectl delete -f FILE, and apply it again. What is done stays in the volume, which pods
# on several nodes must be able to write (ReadWriteMany).
apiVersion: batch/v1
kind: Job
metadata:
  name: {name}
spec:
  completionMode: Indexed
  completions: {shards}
  parallelism: {parallelism}
  backoffLimitPerIndex: {tries}
  podFailurePolicy:
    rules:
      # Bad input, or a device that gives wrong counts: another try would not change it.
      - action: FailJob
        onExitCodes: {{containerName: perirobot, operator: In, values: [1, 2]}}
      # Stopped before the end: no failure, another pod goes on.
      - action: Ignore
        onExitCodes: {{containerName: perirobot, operator: In, values: [75]}}
      - action: Ignore
        onPodConditions: [{{type: DisruptionTarget, status: "True"}}]
{}---
apiVersion: batch/v1
kind: Job
metadata:
  name: {name}-merge
spec:
  suspend: true # until all shards have ended
  backoffLimit: 0
{}"#,
        template(job, pods, &job.sweep()),
        template(job, pods, &job.merge()),
    )
}

/// What every pod of a Job is: one container that runs a command on the volume.
fn template(job: &Job, pods: &Pods, command: &[VisibleWord]) -> String {
    let command: Vec<String> = command.iter().map(VisibleWord::container_argument).collect();
    let (image, claim, mount) = (pods.image.yaml(), pods.claim.yaml(), pods.mount.yaml());
    format!(
        r#"  template:
    spec:
      restartPolicy: Never
      terminationGracePeriodSeconds: {NOTICE_S}
      containers:
        - name: perirobot
          image: {image}
          workingDir: {mount}
          command: [{}]
          resources:
            requests: {{cpu: {}{}}}
{}          volumeMounts:
            - {{name: data, mountPath: {mount}}}
      volumes:
        - name: data
          persistentVolumeClaim: {{claimName: {claim}}}
"#,
        command.join(", "),
        job.cpus,
        job.memory_mib.map(|mib| format!(", memory: {mib}Mi")).unwrap_or_default(),
        job.memory_mib.map(|mib| format!("            limits: {{memory: {mib}Mi}}\n")).unwrap_or_default(),
    )
}

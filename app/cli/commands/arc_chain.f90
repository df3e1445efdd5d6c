!> gracecg estimate of a long run: its arcs, chained.
module gracecg_cli_arc_chain
    use gracecg_base_error, only: error_t
    use gracecg_base_kinds, only: dp
    use gracecg_base_text, only: string_t, append, rounded_text
    use gracecg_environment_time, only: utc_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_arc_chain, only: arc_chain_t, estimate_chain
    use gracecg_estimation_joint_estimate, only: joint_options_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_cli_console, only: console_t
    use gracecg_cli_joint, only: show_joint, publish_joint
    implicit none
    private
    public :: run_chain

contains

    !> Estimates a run in arcs and shows them as `gracecg estimate RUN1 RUN2 ...` shows runs.
    subroutine run_chain(observations, options, joint, length, threads, console, error)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(joint_options_t), intent(in) :: joint
        real(dp), intent(in) :: length      !! Of the arcs, at most, s
        integer, intent(in) :: threads      !! On which arcs are estimated
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(arc_chain_t) :: chain
        type(string_t), allocatable :: names(:)
        type(utc_t), allocatable :: epochs(:)
        integer :: i

        call estimate_chain(observations, options, joint, length, threads, chain, error, console)
        if (allocated(error)) return
        do i = 1, size(chain%warnings)
            call console%warn(chain%warnings(i)%text)
        end do
        allocate (names(0))
        do i = 1, size(chain%arcs)
            associate (arc => chain%arcs(i))
                if (arc%joined) call append(names, rounded_text(arc%from, 6)//'-'//rounded_text(arc%to, 6)//' s')
            end associate
        end do
        epochs = pack(chain%arcs%information%epoch, chain%arcs%joined)
        call show_joint('arcs', names, epochs, chain%solution, console)
        call publish_joint(trim(observations%knowledge%name), names, epochs, chain%solution, console, error)
    end subroutine run_chain
end module gracecg_cli_arc_chain

!> Magnetic attitude control: the law by its identities, a flight under it, and what the operator is told of it.
module test_attitude_control
    use vocabulary
    use calibrations
    use gracecg_base_quaternion, only: quaternion_product, quaternion_from_axis_angle, rotation_angle_between, &
        quaternion_of_matrix
    use gracecg_spacecraft_torque_rods, only: rod_moments
    use gracecg_observations_observation_files, only: read_observations
    use gracecg_simulation_arc, only: truth_arc_t
    use gracecg_simulation_attitude_control, only: attitude_control_t
    use gracecg_simulation_case, only: case_from_text, case_text
    use gracecg_simulation_case_models, only: initial_state
    use gracecg_simulation_simulation_files, only: simulation_order_t, simulation_summary_t, simulate_into
    use gracecg_estimation_optimal, only: estimate_optimal
    use gracecg_estimation_options, only: WAVE_NONE
    implicit none
    private
    public :: collect_attitude_control

    real(dp), parameter :: FIELD(3) = [2.1e-5_dp, -0.7e-5_dp, 3.3e-5_dp]    !! T

contains

    subroutine collect_attitude_control(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('torque-across-the-field', test_torque), &
                    new_unittest('an-oscillator-about-each-axis', test_law), &
                    new_unittest('attitude-is-held', test_flight), &
                    new_unittest('the-operator-is-told', test_told), &
                    new_unittest('case-file', test_case_file)]
    end subroutine collect_attitude_control

    !> Case front-1 under control.
    subroutine controlled_case(case)
        type(case_t), intent(out) :: case

        call take_case('front-1', case)
        case%control%acts = .true.
        associate (a => case%satellite%rods%activations)
            a%amplitude = 25*a%amplitude/30
        end associate
    end subroutine controlled_case

    !> The torque of the moment is the part of the wanted one across the field; the moment has no part along the field,
    !> and stays below its bound however large the error.
    subroutine test_torque(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(attitude_control_t) :: control
        real(dp) :: state(13), wanted(3), m(3), across(3), thrust(3)

        call controlled_case(case)
        state = initial_state(case)
        control = case%control
        call control%hold(state)
        control%greatest_moment = 1e9_dp
        state(10:13) = quaternion_product(quaternion_from_axis_angle([0.6_dp, 0.0_dp, -0.8_dp], 0.3_dp), state(10:13))
        state(7:9) = state(7:9) + [1e-4_dp, -2e-4_dp, 3e-5_dp]
        wanted = control%wanted_torque(state, case%satellite%inertia)
        call control%act(state, case%satellite%inertia, FIELD, m, thrust)
        across = wanted - FIELD*dot_product(FIELD, wanted)/dot_product(FIELD, FIELD)
        call check(error, all(abs(cross(m, FIELD) - across) < 1e-12_dp*norm2(wanted)), 'torque')
        call check(error, all(abs(cross(m, FIELD) + thrust - wanted) < 1e-12_dp*norm2(wanted)), 'with the thrusters: all')
        call check(error, abs(dot_product(m, FIELD)) < 1e-12_dp*norm2(m)*norm2(FIELD), 'moment')
        control%greatest_moment = 5
        call control%act(state, case%satellite%inertia, FIELD, m, thrust)
        call check(error, norm2(m) < 5 .and. norm2(m) > 4.9_dp .and. norm2(cross(cross(m, FIELD), across)) < &
                   1e-12_dp*norm2(across)*norm2(m), 'bounded, with the same direction')
        control%thrusters = .false.
        call control%act(state, case%satellite%inertia, FIELD, m, thrust)
        call check(error, all(abs(thrust) <= 0), 'rods alone')
    end subroutine test_torque

    !> At the attitude and rate that are held nothing is wanted; turned by a small angle, and turning, the torque is
    !> that of an oscillator with the frequency and damping of the law.
    subroutine test_law(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: ANGLE = 1e-4_dp, RATE = 1e-6_dp
        type(case_t) :: case
        type(attitude_control_t) :: control
        real(dp) :: state(13), held(13), axis(3), expected, torque(3)
        integer :: i

        call controlled_case(case)
        held = initial_state(case)
        control = case%control
        control%damping = 0.7_dp
        call control%hold(held)
        associate (r => held(1:3), v => held(4:6))      ! the rate of the orbital axes about body y, which is pitched in plane
            held(7:9) = matmul(control%body_from_orbit, [0.0_dp, -1.0_dp, 0.0_dp])*norm2(cross(r, v))/dot_product(r, r)
        end associate
        torque = control%wanted_torque(held, case%satellite%inertia)
        call check(error, all(abs(torque) < 1e-12_dp), 'at rest')
        do i = 1, 3
            axis = 0
            axis(i) = 1
            state = held
            state(10:13) = quaternion_product(quaternion_from_axis_angle(axis, ANGLE), state(10:13))
            state(7:9) = state(7:9) + RATE*axis
            torque = control%wanted_torque(state, case%satellite%inertia)
            associate (omega => TWO_PI*control%frequency)
                expected = -case%satellite%inertia(i, i)*(omega**2*ANGLE + 2*0.7_dp*omega*RATE)
            end associate
            ! the held rate itself is turned by the angle: 1e-7 rad/s
            call check(error, torque(i), expected, thr=1e-6_dp*abs(expected))
        end do
    end subroutine test_law

    !> A quarter of an hour: the satellite that turns away freely is held, and the same flight comes of one step
    !> an interval and of steps under control.
    subroutine test_flight(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(truth_arc_t) :: held, free, checked

        call controlled_case(case)
        case%duration = 900
        case%interval = 1
        case%gravity_degree = 2
        case%gravity_order = 0
        case%satellite%rods%activations%stop = 60
        call make_arc(case, held)
        case%integrator = 'rkf78-fixed'
        call make_arc(case, checked)
        case%control%acts = .false.
        call make_arc(case, free)
        call check(error, away(held) < 0.3_dp*DEGREE .and. away(free) > 1*DEGREE, 'held')
        call check(error, maxval(abs(held%state(10:13, :) - checked%state(10:13, :))) < 1e-9_dp .and. &
                   maxval(abs(held%state(7:9, :) - checked%state(7:9, :))) < 1e-12_dp, 'steps')

    contains

        !> The greatest turn from the held attitude, rad.
        real(dp) function away(arc)
            type(truth_arc_t), intent(in) :: arc
            type(attitude_control_t) :: control
            integer :: k

            call control%hold(arc%state(:, 0))
            away = 0
            do k = 0, arc%steps
                away = max(away, rotation_angle_between(quaternion_of_matrix(control%turn(arc%state(:, k))), &
                                                        [0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp]))
            end do
        end function away
    end subroutine test_flight

    !> The operator has the moments that turned the satellite: torque over field at every epoch, in files as in memory;
    !> with them the offset is found.
    subroutine test_told(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(simulator_t) :: simulator
        type(simulation_order_t) :: order
        type(simulation_summary_t) :: summary
        type(observation_set_t) :: observations, from_files
        type(estimation_options_t) :: options
        type(solution_t) :: solution
        type(error_t), allocatable :: failure
        real(dp) :: moment(3), torque(3), most
        integer :: k

        call controlled_case(case)
        case%density_wave%amplitude = 0
        case%control%frequency = 2e-3_dp
        call make_simulator(case, simulator)
        call make_observations(simulator, 1, 1, observations)
        most = 0
        do k = 0, simulator%arc%steps
            moment = rod_moments(observations%knowledge%rods, k*simulator%arc%interval)
            associate (acting => simulator%arc%loads(k))
                torque = cross(moment, acting%field)
                call check(error, all(abs(torque - acting%torque_magnetic) < 1e-12_dp), 'moments')
                most = max(most, norm2(moment - rod_moments(case%satellite%rods, k*simulator%arc%interval)))
            end associate
        end do
        call check(error, most > 0.1_dp .and. most < case%control%greatest_moment, 'the law commands something')
        options%optimal%density_wave = WAVE_NONE
        options%test_beliefs = .false.
        call estimate_optimal(observations, options, solution, failure)
        if (failed(error, failure)) return
        call check(error, all(abs(solution%offset - case%satellite%offset) < &
                              5*sigmas(solution%covariance)), 'offset')

        order%folder = FOLDER//'controlled'
        order%case = case
        allocate (order%comments(0))
        call simulate_into(order, summary, failure)
        if (.not. allocated(failure)) call read_observations(order%folder, from_files, failure)
        if (failed(error, failure)) return
        associate (told => observations%knowledge%rods%measured, read => from_files%knowledge%rods%measured)
            call check(error, size(read%time) == 601 .and. all(abs(read%time - told%time) < 1e-12_dp) .and. &
                       all(abs(read%moment - told%moment) <= 0), 'rods.csv')
        end associate
    end subroutine test_told

    !> The group of a case file comes back as written, stands in no other file, and what is wrong in it is refused.
    subroutine test_case_file(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case, again
        type(error_t), allocatable :: failure
        character(:), allocatable :: text, plain

        call controlled_case(case)
        case%control%damping = 0.6_dp
        call case_text(case, text, failure)
        if (.not. allocated(failure)) call case_from_text(text, 'a case', again, failure)
        if (failed(error, failure)) return
        call check(error, again%control%acts .and. abs(again%control%damping - 0.6_dp) <= 0)
        case%control%acts = .false.
        call case_text(case, plain, failure)
        call check(error, index(plain, '&control') == 0 .and. index(text, '&control') > 0, 'off by default')

        call refused('    damping = 0.6', '    damping = 60', 'a case: ... damping ... 0.1 ... 10')
        if (.not. allocated(error)) call refused('    damping = 0.6', '    dumping = 0.6', 'a case: ... dumping ... damping')
        if (.not. allocated(error)) call refused('    greatest_moment = 5', '    greatest_moment = 6', &
                                                 'greatest_moment = 6 ... torque rod 2 ... add up to 31 ... at most 30')
        if (.not. allocated(error)) call refused('misalignment_deg = 0,', 'misalignment_deg = 1,', &
                                                 'control ... misalignment_deg')

    contains

        subroutine refused(line, changed, parts)
            character(*), intent(in) :: line, changed
            character(*), intent(in) :: parts

            call case_from_text(replaced(text, line, changed), 'a case', again, failure)
            call check_fails(error, failure, parts)
        end subroutine refused
    end subroutine test_case_file
end module test_attitude_control

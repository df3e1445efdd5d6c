!> The CG offset from samples in memory: arrays of one's own become an observation set, and that an
!> estimate.
!>
!>     fpm run --example calibrate
!>     gfortran calibrate.f90 $(pkg-config --cflags --libs gracecg)
!>
!> The samples here are simulated, those of `gracecg simulate front-3`; the estimate is that of
!> `gracecg estimate`.
program calibrate
    use gracecg, only: dp, error_t, observation_set_t, operator_knowledge_t, solution_t, &
        estimate_offset, estimation_options_t, fit_record_t, fit_diagnostics_t, diagnose, verdict_t, judge, &
        case_t, find_case, simulator_t, new_simulator, observe
    implicit none
    real(dp), allocatable :: t_acc(:), acc(:, :)        ! s; (3, n), body axes, m/s^2
    real(dp), allocatable :: t_star(:), quaternion(:, :) ! s; (4, n), inertial to camera, scalar last
    integer, allocatable :: head(:)                     ! star-camera head of each quaternion, 1 or 2
    real(dp), allocatable :: t_mag(:), field(:, :)      ! s; (3, n), body axes, T
    real(dp), allocatable :: t_orbit(:), position(:, :) ! s; (3, n), inertial J2000, m
    type(operator_knowledge_t) :: knowledge
    type(observation_set_t) :: observations
    type(solution_t) :: solution
    type(fit_record_t) :: record
    type(fit_diagnostics_t) :: diagnostics
    type(verdict_t) :: verdict
    type(error_t), allocatable :: error
    integer :: i

    call read_my_data(error)
    if (allocated(error)) error stop error%message

    observations%knowledge = knowledge
    observations%accelerometer_time = t_acc
    observations%acceleration = acc
    observations%star_camera_time = t_star
    observations%star_camera_head = head
    observations%quaternion = quaternion
    observations%magnetometer_time = t_mag
    observations%field = field
    ! With the orbit the magnetometer is compared with the field model: without it nothing tests its scale
    observations%orbit_time = t_orbit
    observations%orbit_position = position
    ! estimation_options_t() says nothing of how to estimate: weights and first guesses are the defaults
    call estimate_offset('assest-fde', observations, estimation_options_t(), solution, error, record)
    if (.not. allocated(error)) call diagnose(knowledge, solution, record, diagnostics, error)
    if (allocated(error)) error stop error%message
    verdict = judge(knowledge, solution, record, diagnostics)

    ! What to do comes first: numbers are there also when they are not to be used
    print '(a)', verdict%action%text

    print '(a, 3(i0, a))', 'from ', size(t_acc), ' accelerations, ', size(t_star), ' quaternions, ', &
        size(t_mag), ' samples of the magnetic field'
    print '(a)', 'offset from the centre of mass to the proof mass, body axes'
    do i = 1, 3
        print '(3a, f12.7, a, f10.7, a)', 'd_', 'xyz'(i:i), ' = ', 1e3_dp*solution%offset(i), ' mm +- ', &
            1e3_dp*sqrt(solution%covariance(i, i)), ' mm'
    end do
    do i = 1, size(solution%warnings)
        print '(2a)', 'warning: ', solution%warnings(i)%text
    end do

contains

    !> Fills the arrays: here by simulation, in real life from files of Level-1 data. `setup` is what an
    !> operator knows: epoch, duration, mass, inertia, torque rods, mounting and noise of the instruments.
    subroutine read_my_data(error)
        type(error_t), allocatable, intent(out) :: error
        type(case_t) :: case
        type(simulator_t) :: simulator
        type(observation_set_t) :: simulated
        integer, parameter :: SEED = 1, RUN = 1

        call find_case('front-3', case, error)
        if (.not. allocated(error)) call new_simulator(case, simulator, error)
        if (.not. allocated(error)) call observe(simulator, SEED, RUN, simulated, error)
        if (allocated(error)) return
        knowledge = simulated%knowledge
        t_acc = simulated%accelerometer_time
        acc = simulated%acceleration
        t_star = simulated%star_camera_time
        head = simulated%star_camera_head
        quaternion = simulated%quaternion
        t_mag = simulated%magnetometer_time
        field = simulated%field
        t_orbit = simulated%orbit_time
        position = simulated%orbit_position
    end subroutine read_my_data
end program calibrate

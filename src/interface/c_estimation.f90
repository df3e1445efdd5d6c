!> The C interface: simulation, observation sets, estimation. Documented in include/gracecg.h.
module gracecg_interface_c_estimation
    use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_f_pointer, c_int, &
        c_int32_t, c_intptr_t, c_null_char, c_ptr, c_size_t
    use gracecg, only: dp, error_t, simulator_t, new_simulator, observe, observation_set_t, &
        operator_knowledge_t, check_observations, read_observations, write_observations, read_setup, &
        setup_from_text, setup_text, estimation_options_t, read_options, write_options, options_from_text, &
        options_text, OF_SETUP, solution_t, estimate_offset, ESTIMATOR_NAMES, STATE_SIZE, moment_series_t, &
        new_moment_series, take_measured_moments
    use gracecg_base_kinds, only: i8
    use gracecg_base_error, only: fail
    use gracecg_base_text, only: integer_text
    use gracecg_estimation_belief_report, only: CONTRADICTED, UNTESTED
    use gracecg_estimation_belief_words, only: say_contradiction, say_untested
    use gracecg_environment_time, only: time_tag
    use gracecg_files_file, only: file_exists
    use gracecg_observations_observation_files, only: OBSERVATION_FILES, SETUP_FILE
    use gracecg_interface_handles, only: object_t, acquire, release
    use gracecg_interface_c_support, only: c_error_t, STATUS_OK, STATUS_BAD_SIZE, STATUS_BAD_VALUE, &
        STATUS_NOT_CONVERGED, STATUS_NO_MEMORY, LONGEST_NAME, LONGEST_TEXT, start, &
        raise, pass_on, need, check_count, check_result, fortran_text, give_text, give_lines, give_warnings, keep, &
        refuse_handle, free_object
    use gracecg_interface_c_dynamics, only: case_object_t
    implicit none
    private
    public :: c_samples_t, c_solution_t, c_beliefs_t, c_test_beliefs, create_observations, observations_object_t
    public :: c_simulator_open, c_simulator_free, c_simulator_truth
    public :: c_setup_read, c_setup_parse, c_setup_free, c_setup_text, c_setup_measured, setup_with_moments
    public :: c_observations_create, c_observations_read, c_observations_write, c_observations_simulate
    public :: c_observations_free, c_observations_setup, c_observations_counts
    public :: c_observations_accelerometer, c_observations_star_camera, c_observations_magnetometer
    public :: c_observations_orbit, c_options_text, c_options_replace, c_estimate
    public :: give_solution, check_capacity

    integer, parameter :: MOST_PARAMETERS = 16      !! Beside the offset
    integer, parameter :: NAME_SIZE = 16            !! Bytes of a parameter's name with its closing zero

    !> gracecg_samples
    type, bind(c) :: c_samples_t
        integer(c_size_t) :: accelerometer_count    !! Number of samples
        type(c_ptr) :: accelerometer_time       !! s
        type(c_ptr) :: acceleration             !! [count][3], m/s^2
        integer(c_size_t) :: star_camera_count  !! Number of samples
        type(c_ptr) :: star_camera_time         !! s
        type(c_ptr) :: star_camera_head         !! int32_t, 1 or 2
        type(c_ptr) :: quaternion               !! [count][4]
        integer(c_size_t) :: magnetometer_count !! Number of samples
        type(c_ptr) :: magnetometer_time        !! s
        type(c_ptr) :: flux_density             !! [count][3], T
        integer(c_size_t) :: orbit_count        !! Number of samples
        type(c_ptr) :: orbit_time               !! s
        type(c_ptr) :: orbit_position           !! [count][3], m
    end type c_samples_t

    !> gracecg_solution
    type, bind(c) :: c_solution_t
        real(c_double) :: offset(3)             !! m
        real(c_double) :: sigma(3)              !! m
        real(c_double) :: covariance(3, 3)      !! m^2
        real(c_double) :: drift(3)              !! m/s^3
        real(c_double) :: bias(3)               !! m/s^2
        real(c_double) :: quaternion(4)         !! At the epoch, inertial to body, scalar last
        real(c_double) :: angular_velocity(3)   !! rad/s
        real(c_double) :: residual_rms(3)       !! m/s^2
        real(c_double) :: condition             !! Of the scaled normal matrix
        real(c_double) :: variance_factor       !! 0: the estimator has none
        real(c_double) :: noise_level(3)        !! m^2 s^-4/Hz
        real(c_double) :: noise_corner(3)       !! Hz
        real(c_double) :: star_camera_sigma(3)  !! rad
        real(c_double) :: parameter_value(MOST_PARAMETERS)  !! SI units
        real(c_double) :: parameter_sigma(MOST_PARAMETERS)  !! SI units
        character(kind=c_char) :: parameter_name(NAME_SIZE, MOST_PARAMETERS)    !! Ends with a zero
        integer(c_int32_t) :: parameter_count   !! How many there are
        integer(c_int32_t) :: edited(2)         !! Accelerometer, star camera
        integer(c_int32_t) :: iterations        !! Of the batch processor
        integer(c_int32_t) :: converged         !! 1 or 0
        integer(c_int32_t) :: warning_count     !! How many there are
    end type c_solution_t

    !> gracecg_beliefs
    type, bind(c) :: c_beliefs_t
        real(c_double) :: undetected(3)         !! Effect of a wrong belief that no test sees, with `apart`, m
        real(c_double) :: apart(3)              !! From the estimate of `optimal`, m
        integer(c_int32_t) :: tested            !! How many
        integer(c_int32_t) :: contradicted      !! How many of them
        integer(c_int32_t) :: untested          !! How many could not be tested well enough
        integer(c_int32_t) :: sign_known        !! Of the accelerometer: 1 or 0
    end type c_beliefs_t

    type, extends(object_t) :: simulator_object_t
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options       !! Of its case
    end type simulator_object_t

    type, extends(object_t) :: setup_object_t
        type(operator_knowledge_t) :: knowledge
        type(estimation_options_t) :: options       !! Beside it
    end type setup_object_t

    !> Observations behind a handle, with how they are estimated.
    type, extends(object_t) :: observations_object_t
        type(observation_set_t) :: set                  !! The samples, and what the operator knows
        type(estimation_options_t) :: options       !! How to estimate from it
    end type observations_object_t

    character(*), parameter :: CASE_NAME = 'case', SIMULATOR_NAME = 'simulator'
    character(*), parameter :: SETUP_NAME = 'setup', SET_NAME = 'observation set'
    character(*), parameter :: WITH_OPTIONS = 'case, setup or observation set'
    character(*), parameter :: OPTIONS_FILE = 'options.nml'     !! In the folder of an observation set
    integer, parameter :: MOST_SAMPLES = 10000000       !! Of one instrument
    ! The arrays of an instrument without samples
    real(dp), save, target :: NO_TIMES(0), NO_VALUES(4, 0)
    integer(c_int32_t), save, target :: NO_HEADS(0)

contains

    !> gracecg_simulator_open
    function c_simulator_open(case_handle, handle, error) result(status) &
        bind(c, name='gracecg_simulator_open')
        integer(c_intptr_t), intent(in), value :: case_handle
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object, new_object
        type(simulator_object_t), pointer :: made
        type(error_t), allocatable :: failure
        integer :: memory

        call start(status, error)
        call need(present(handle), SIMULATOR_NAME, status, error)
        if (present(handle)) handle = 0
        if (status /= STATUS_OK) return
        new_object => null()
        call acquire(int(case_handle, i8), object)
        select type (object)
        type is (case_object_t)
            allocate (made, stat=memory)
            if (memory == 0) then
                new_object => made
                call new_simulator(object%calibration%case, made%simulator, failure)
                made%options = object%calibration%options
                call pass_on(failure, status, error)
            end if
        class default
            call refuse_handle(CASE_NAME, status, error)
        end select
        call release(int(case_handle, i8), object)
        call keep(new_object, handle, status, error)
    end function c_simulator_open

    !> gracecg_simulator_free
    function c_simulator_free(handle, error) result(status) bind(c, name='gracecg_simulator_free')
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(simulator_object_t) :: mold

        call free_object(handle, SIMULATOR_NAME, status, error, mold)
    end function c_simulator_free

    !> gracecg_simulator_truth
    function c_simulator_truth(handle, capacity, count, seconds, states, angular_acceleration, &
                               flux_density, non_gravitational, error) result(status) &
        bind(c, name='gracecg_simulator_truth')
        integer(c_intptr_t), intent(in), value :: handle
        integer(c_size_t), intent(in), value :: capacity
        integer(c_size_t), intent(inout), optional :: count
        real(c_double), intent(inout), optional :: seconds(*), states(STATE_SIZE, *)
        real(c_double), intent(inout), optional :: angular_acceleration(3, *), flux_density(3, *)
        real(c_double), intent(inout), optional :: non_gravitational(3, *)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        logical :: wanted
        integer :: k

        call start(status, error)
        call check_count(capacity, 'capacity', status, error)
        if (status /= STATUS_OK) return
        wanted = present(seconds) .or. present(states) .or. present(angular_acceleration) .or. &
                 present(flux_density) .or. present(non_gravitational)
        call acquire(int(handle, i8), object)
        select type (object)
        type is (simulator_object_t)
            associate (arc => object%simulator%arc)
                if (present(count)) count = arc%steps + 1
                if (wanted) call check_capacity(arc%steps + 1, capacity, status, error)
                if (wanted .and. status == STATUS_OK) then
                    do k = 0, arc%steps
                        if (present(seconds)) seconds(k + 1) = time_tag(k, arc%interval)
                        if (present(states)) states(:, k + 1) = arc%state(:, k)
                        if (present(angular_acceleration)) &
                            angular_acceleration(:, k + 1) = arc%omega_dot(:, k)
                        if (present(flux_density)) flux_density(:, k + 1) = arc%loads(k)%field
                        if (present(non_gravitational)) non_gravitational(:, k + 1) = &
                            arc%loads(k)%drag + arc%loads(k)%srp + arc%loads(k)%erp
                    end do
                end if
            end associate
        class default
            call refuse_handle(SIMULATOR_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_simulator_truth

    !> Room for n elements.
    subroutine check_capacity(n, capacity, status, error)
        integer, intent(in) :: n    !! Elements that there are
        integer(c_size_t), intent(in) :: capacity    !! Elements that the caller has room for
        integer(c_int), intent(inout) :: status    !! A gracecg_status
        type(c_error_t), intent(inout), optional :: error

        if (status /= STATUS_OK .or. capacity >= n) return
        call raise(STATUS_BAD_SIZE, 'capacity = '//integer_text(int(capacity, i8))//' is too small: there are '// &
                   integer_text(n)//' elements', status, error)
    end subroutine check_capacity

    !> gracecg_setup_read
    function c_setup_read(file, handle, error) result(status) bind(c, name='gracecg_setup_read')
        character(kind=c_char), intent(in), optional :: file(*)
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(operator_knowledge_t) :: knowledge
        type(estimation_options_t) :: options
        type(error_t), allocatable :: failure
        character(:), allocatable :: path

        call start(status, error)
        call need(present(handle), SETUP_NAME, status, error)
        if (present(handle)) handle = 0
        call fortran_text(file, LONGEST_NAME, 'file', path, status, error)
        if (status /= STATUS_OK) return
        call read_setup(path, knowledge, failure)
        if (.not. allocated(failure)) call read_options_beside(path, options, failure)
        call pass_on(failure, status, error)
        if (status == STATUS_OK) call keep_setup(knowledge, options, handle, status, error)
    end function c_setup_read

    !> gracecg_setup_parse
    function c_setup_parse(text, handle, error) result(status) bind(c, name='gracecg_setup_parse')
        character(kind=c_char), intent(in), optional :: text(*)
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(operator_knowledge_t) :: knowledge
        type(estimation_options_t) :: options
        type(error_t), allocatable :: failure
        character(:), allocatable :: settings

        call start(status, error)
        call need(present(handle), SETUP_NAME, status, error)
        if (present(handle)) handle = 0
        call fortran_text(text, LONGEST_TEXT, 'text', settings, status, error)
        if (status /= STATUS_OK) return
        call setup_from_text(settings, 'text', knowledge, failure)
        if (.not. allocated(failure)) call options_from_text(settings, 'text', options, failure, OF_SETUP)
        call pass_on(failure, status, error)
        if (status == STATUS_OK) call keep_setup(knowledge, options, handle, status, error)
    end function c_setup_parse

    subroutine keep_setup(knowledge, options, handle, status, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(estimation_options_t), intent(in) :: options
        integer(c_intptr_t), intent(out) :: handle
        integer(c_int), intent(inout) :: status
        type(c_error_t), intent(inout), optional :: error

        class(object_t), pointer :: object
        type(setup_object_t), pointer :: made
        integer :: memory

        allocate (made, stat=memory)
        object => null()
        if (memory == 0) then
            object => made
            made%knowledge = knowledge
            made%options = options
        end if
        call keep(object, handle, status, error)
    end subroutine keep_setup

    !> gracecg_setup_measured
    function c_setup_measured(handle, n, time, moment, new_handle, error) result(status) &
        bind(c, name='gracecg_setup_measured')
        integer(c_intptr_t), intent(in), value :: handle
        integer(c_size_t), intent(in), value :: n
        real(c_double), intent(in), optional :: time(*), moment(3, *)
        integer(c_intptr_t), intent(inout), optional :: new_handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        call start(status, error)
        call need(present(new_handle), SETUP_NAME, status, error)
        if (present(new_handle)) new_handle = 0
        call check_count(n, 'the number of moments', status, error, MOST_SAMPLES)
        call need(present(time) .and. present(moment), 'time or moment', status, error)
        if (status == STATUS_OK) call setup_with_moments(handle, time(:n), moment(:, :n), new_handle, status, error)
    end function c_setup_measured

    !> A setup with measured moments of the rods, for C and Fortran 77.
    subroutine setup_with_moments(handle, time, moment, new_handle, status, error)
        integer(c_intptr_t), intent(in) :: handle           !! Of the setup without
        real(dp), intent(in) :: time(:), moment(:, :)       !! s; (3, n), along the rods, A m^2
        integer(c_intptr_t), intent(out) :: new_handle      !! Of the setup with them; 0 after a failure
        integer(c_int), intent(inout) :: status             !! Of the call so far: nothing is done after a failure
        type(c_error_t), intent(inout), optional :: error

        class(object_t), pointer :: object
        type(operator_knowledge_t) :: knowledge
        type(estimation_options_t) :: options
        type(moment_series_t) :: series
        type(error_t), allocatable :: failure

        new_handle = 0
        if (status /= STATUS_OK) return
        call new_moment_series(series, time, moment, failure)
        call pass_on(failure, status, error, STATUS_BAD_VALUE)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (setup_object_t)
            knowledge = object%knowledge
            options = object%options
        class default
            call refuse_handle(SETUP_NAME, status, error)
        end select
        call release(int(handle, i8), object)
        if (status /= STATUS_OK) return
        call take_measured_moments(series, knowledge%rods)
        call keep_setup(knowledge, options, new_handle, status, error)
    end subroutine setup_with_moments

    !> gracecg_setup_free
    function c_setup_free(handle, error) result(status) bind(c, name='gracecg_setup_free')
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(setup_object_t) :: mold

        call free_object(handle, SETUP_NAME, status, error, mold)
    end function c_setup_free

    !> gracecg_setup_text
    function c_setup_text(handle, text, size, length, error) result(status) &
        bind(c, name='gracecg_setup_text')
        integer(c_intptr_t), intent(in), value :: handle
        character(kind=c_char), intent(inout), optional :: text(*)
        integer(c_size_t), intent(in), value :: size
        integer(c_size_t), intent(inout), optional :: length
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        type(error_t), allocatable :: failure
        character(:), allocatable :: settings, options

        call start(status, error)
        call check_count(size, 'size', status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (setup_object_t)
            call setup_text(object%knowledge, settings, failure)
            if (.not. allocated(failure)) call options_text(object%options, options, failure)
            if (.not. allocated(failure)) settings = settings//new_line('a')//new_line('a')//options
            call pass_on(failure, status, error)
            if (status == STATUS_OK) call give_text(settings, text, size, length, status, error)
        class default
            call refuse_handle(SETUP_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_setup_text

    !> gracecg_observations_create
    function c_observations_create(setup_handle, samples, handle, error) result(status) &
        bind(c, name='gracecg_observations_create')
        integer(c_intptr_t), intent(in), value :: setup_handle
        type(c_samples_t), intent(in), optional :: samples
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        real(dp), pointer, dimension(:) :: accelerometer_time, star_camera_time, magnetometer_time, orbit_time
        real(dp), pointer, dimension(:, :) :: acceleration, quaternion, field, position
        integer(c_int32_t), pointer :: head(:)

        call start(status, error)
        call need(present(handle), 'observations', status, error)
        if (present(handle)) handle = 0
        call need(present(samples), 'samples', status, error)
        if (status /= STATUS_OK) return
        call point_to(samples%accelerometer_count, samples%accelerometer_time, samples%acceleration, 3, &
                      'accelerometer', accelerometer_time, acceleration, status, error)
        call point_to(samples%star_camera_count, samples%star_camera_time, samples%quaternion, 4, &
                      'star camera', star_camera_time, quaternion, status, error)
        call point_to(samples%magnetometer_count, samples%magnetometer_time, samples%flux_density, 3, &
                      'magnetometer', magnetometer_time, field, status, error)
        call point_to(samples%orbit_count, samples%orbit_time, samples%orbit_position, 3, 'orbit', &
                      orbit_time, position, status, error)
        if (samples%star_camera_count /= 0) &
            call need(c_associated(samples%star_camera_head), 'star_camera_head', status, error)
        if (status /= STATUS_OK) return
        head => NO_HEADS
        if (samples%star_camera_count > 0) &
            call c_f_pointer(samples%star_camera_head, head, [samples%star_camera_count])
        call create_observations(setup_handle, accelerometer_time, acceleration, star_camera_time, head, &
                                 quaternion, magnetometer_time, field, orbit_time, position, handle, &
                                 status, error)
    end function c_observations_create

    !> The arrays of one instrument.
    subroutine point_to(n, c_times, c_values, components, name, times, values, status, error)
        integer(c_size_t), intent(in) :: n
        type(c_ptr), intent(in) :: c_times, c_values
        integer, intent(in) :: components           !! Of a value
        character(*), intent(in) :: name
        real(dp), pointer, intent(out) :: times(:), values(:, :)
        integer(c_int), intent(inout) :: status
        type(c_error_t), intent(inout), optional :: error

        times => NO_TIMES
        values => NO_VALUES(:components, :)
        call check_count(n, 'the number of samples of the '//name, status, error, MOST_SAMPLES)
        if (n /= 0) call need(c_associated(c_times) .and. c_associated(c_values), &
                              'samples, an array of the '//name//',', status, error)
        if (status /= STATUS_OK .or. n == 0) return
        call c_f_pointer(c_times, times, [n])
        call c_f_pointer(c_values, values, [int(components, c_size_t), n])
    end subroutine point_to

    !> Makes an observation set from arrays, for C and Fortran 77.
    subroutine create_observations(setup_handle, accelerometer_time, acceleration, star_camera_time, head, &
                                   quaternion, magnetometer_time, field, orbit_time, position, handle, &
                                   status, error)
        integer(c_intptr_t), intent(in) :: setup_handle                     !! Of the setup
        real(dp), intent(in) :: accelerometer_time(:), acceleration(:, :)   !! s; (3, n), m/s^2
        real(dp), intent(in) :: star_camera_time(:), quaternion(:, :)       !! s; (4, n)
        integer(c_int32_t), intent(in) :: head(:)
        !! Star-camera head of each quaternion, 1 or 2
        real(dp), intent(in) :: magnetometer_time(:), field(:, :)           !! s; (3, n), T
        real(dp), intent(in) :: orbit_time(:), position(:, :)               !! s; (3, n), m
        integer(c_intptr_t), intent(out) :: handle
        !! Of the observation set; 0 after a failure
        integer(c_int), intent(inout) :: status
        !! Of the call so far: nothing is done after a failure
        type(c_error_t), intent(inout), optional :: error

        class(object_t), pointer :: object, new_object
        type(observations_object_t), pointer :: made
        type(error_t), allocatable :: failure
        integer :: memory

        handle = 0
        if (status /= STATUS_OK) return
        new_object => null()
        call acquire(int(setup_handle, i8), object)
        select type (object)
        type is (setup_object_t)
            allocate (made, stat=memory)
            if (memory == 0) then
                new_object => made
                made%set%knowledge = object%knowledge
                made%options = object%options
                allocate (made%set%accelerometer_time, source=accelerometer_time, stat=memory)
                if (memory == 0) allocate (made%set%acceleration, source=acceleration, stat=memory)
                if (memory == 0) allocate (made%set%star_camera_time, source=star_camera_time, stat=memory)
                if (memory == 0) allocate (made%set%star_camera_head, source=int(head), stat=memory)
                if (memory == 0) allocate (made%set%quaternion, source=quaternion, stat=memory)
                if (memory == 0) allocate (made%set%magnetometer_time, source=magnetometer_time, stat=memory)
                if (memory == 0) allocate (made%set%field, source=field, stat=memory)
                if (size(orbit_time) > 0) then
                    if (memory == 0) allocate (made%set%orbit_time, source=orbit_time, stat=memory)
                    if (memory == 0) allocate (made%set%orbit_position, source=position, stat=memory)
                end if
                if (memory /= 0) call raise(STATUS_NO_MEMORY, 'no memory for the samples', status, error)
            end if
            if (status == STATUS_OK .and. associated(new_object)) then
                call check_observations(made%set, failure)
                call pass_on(failure, status, error, STATUS_BAD_VALUE)
            end if
        class default
            call refuse_handle(SETUP_NAME, status, error)
        end select
        call release(int(setup_handle, i8), object)
        call keep(new_object, handle, status, error)
    end subroutine create_observations

    !> gracecg_observations_read
    function c_observations_read(folder, handle, error) result(status) &
        bind(c, name='gracecg_observations_read')
        character(kind=c_char), intent(in), optional :: folder(*)
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: new_object
        type(observations_object_t), pointer :: made
        type(error_t), allocatable :: failure
        character(:), allocatable :: path
        integer :: memory

        call start(status, error)
        call need(present(handle), 'observations', status, error)
        if (present(handle)) handle = 0
        call fortran_text(folder, LONGEST_NAME, 'folder', path, status, error)
        if (status /= STATUS_OK) return
        allocate (made, stat=memory)
        new_object => null()
        if (memory == 0) then
            new_object => made
            call read_observations(path, made%set, failure)
            if (.not. allocated(failure)) call read_options_beside( &
                path//'/'//trim(OBSERVATION_FILES(SETUP_FILE)), made%options, failure)
            call pass_on(failure, status, error)
        end if
        call keep(new_object, handle, status, error)
    end function c_observations_read

    !> The options that belong to a setup.nml: those of options.nml in its folder, else those in itself, if it
    !> is one of version 0.1.
    subroutine read_options_beside(setup, options, error)
        character(*), intent(in) :: setup           !! Path of the setup.nml
        type(estimation_options_t), intent(out) :: options
        type(error_t), allocatable, intent(out) :: error

        associate (path => setup(:index(setup, '/', back=.true.))//OPTIONS_FILE)
            if (file_exists(path)) then
                call read_options(path, options, error)
            else
                call read_options(setup, options, error, OF_SETUP)
            end if
        end associate
    end subroutine read_options_beside

    !> gracecg_options_text
    function c_options_text(handle, text, size, length, error) result(status) &
        bind(c, name='gracecg_options_text')
        integer(c_intptr_t), intent(in), value :: handle
        character(kind=c_char), intent(inout), optional :: text(*)
        integer(c_size_t), intent(in), value :: size
        integer(c_size_t), intent(inout), optional :: length
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        type(estimation_options_t) :: options
        type(error_t), allocatable :: failure
        character(:), allocatable :: settings

        call start(status, error)
        call check_count(size, 'size', status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (case_object_t)
            options = object%calibration%options
        type is (setup_object_t)
            options = object%options
        type is (observations_object_t)
            options = object%options
        class default
            call refuse_handle(WITH_OPTIONS, status, error)
        end select
        call release(int(handle, i8), object)
        if (status /= STATUS_OK) return
        call options_text(options, settings, failure)
        call pass_on(failure, status, error)
        if (status == STATUS_OK) call give_text(settings, text, size, length, status, error)
    end function c_options_text

    !> gracecg_options_replace
    function c_options_replace(handle, text, new_handle, error) result(status) &
        bind(c, name='gracecg_options_replace')
        integer(c_intptr_t), intent(in), value :: handle
        character(kind=c_char), intent(in), optional :: text(*)
        integer(c_intptr_t), intent(inout), optional :: new_handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object, new_object
        type(estimation_options_t) :: options
        type(error_t), allocatable :: failure
        character(:), allocatable :: settings
        integer :: memory

        call start(status, error)
        call need(present(new_handle), 'the new handle', status, error)
        if (present(new_handle)) new_handle = 0
        call fortran_text(text, LONGEST_TEXT, 'text', settings, status, error)
        if (status /= STATUS_OK) return
        call options_from_text(settings, 'text', options, failure)
        call pass_on(failure, status, error)
        if (status /= STATUS_OK) return
        new_object => null()
        call acquire(int(handle, i8), object)
        select type (object)
        type is (case_object_t)
            allocate (new_object, source=object, stat=memory)
        type is (setup_object_t)
            allocate (new_object, source=object, stat=memory)
        type is (observations_object_t)
            allocate (new_object, source=object, stat=memory)
        class default
            call refuse_handle(WITH_OPTIONS, status, error)
        end select
        call release(int(handle, i8), object)
        if (status /= STATUS_OK) return
        if (associated(new_object)) then
            select type (new_object)
            type is (case_object_t)
                new_object%calibration%options = options
            type is (setup_object_t)
                new_object%options = options
            type is (observations_object_t)
                new_object%options = options
            end select
        end if
        call keep(new_object, new_handle, status, error)
    end function c_options_replace

    !> gracecg_observations_write
    function c_observations_write(handle, folder, error) result(status) &
        bind(c, name='gracecg_observations_write')
        integer(c_intptr_t), intent(in), value :: handle
        character(kind=c_char), intent(in), optional :: folder(*)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        type(error_t), allocatable :: failure
        character(:), allocatable :: path
        character(1) :: no_comments(0)

        call start(status, error)
        call fortran_text(folder, LONGEST_NAME, 'folder', path, status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (observations_object_t)
            call write_observations(path, object%set, no_comments, failure)
            if (.not. allocated(failure)) call write_options(path//'/'//OPTIONS_FILE, object%options, &
                    no_comments, failure)
            call pass_on(failure, status, error)
        class default
            call refuse_handle(SET_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_observations_write

    !> gracecg_observations_simulate
    function c_observations_simulate(simulator_handle, seed, run, handle, error) result(status) &
        bind(c, name='gracecg_observations_simulate')
        integer(c_intptr_t), intent(in), value :: simulator_handle
        integer(c_int32_t), intent(in), value :: seed, run
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object, new_object
        type(observations_object_t), pointer :: made
        type(error_t), allocatable :: failure
        integer :: memory

        call start(status, error)
        call need(present(handle), 'observations', status, error)
        if (present(handle)) handle = 0
        if (status == STATUS_OK .and. run < 0) &
            call raise(STATUS_BAD_VALUE, 'run = '//integer_text(run)//' must not be negative', status, error)
        if (status /= STATUS_OK) return
        new_object => null()
        call acquire(int(simulator_handle, i8), object)
        select type (object)
        type is (simulator_object_t)
            allocate (made, stat=memory)
            if (memory == 0) then
                new_object => made
                made%options = object%options
                call observe(object%simulator, seed, run, made%set, failure)
                call pass_on(failure, status, error)
            end if
        class default
            call refuse_handle(SIMULATOR_NAME, status, error)
        end select
        call release(int(simulator_handle, i8), object)
        call keep(new_object, handle, status, error)
    end function c_observations_simulate

    !> gracecg_observations_free
    function c_observations_free(handle, error) result(status) bind(c, name='gracecg_observations_free')
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(observations_object_t) :: mold

        call free_object(handle, SET_NAME, status, error, mold)
    end function c_observations_free

    !> gracecg_observations_setup
    function c_observations_setup(handle, setup_handle, error) result(status) &
        bind(c, name='gracecg_observations_setup')
        integer(c_intptr_t), intent(in), value :: handle
        integer(c_intptr_t), intent(inout), optional :: setup_handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        type(operator_knowledge_t) :: knowledge
        type(estimation_options_t) :: options

        call start(status, error)
        call need(present(setup_handle), SETUP_NAME, status, error)
        if (present(setup_handle)) setup_handle = 0
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (observations_object_t)
            knowledge = object%set%knowledge
            options = object%options
        class default
            call refuse_handle(SET_NAME, status, error)
        end select
        call release(int(handle, i8), object)
        if (status == STATUS_OK) call keep_setup(knowledge, options, setup_handle, status, error)
    end function c_observations_setup

    !> gracecg_observations_counts
    function c_observations_counts(handle, counts, error) result(status) &
        bind(c, name='gracecg_observations_counts')
        integer(c_intptr_t), intent(in), value :: handle
        integer(c_size_t), intent(inout), optional :: counts(4)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object

        call start(status, error)
        call need(present(counts), 'counts', status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (observations_object_t)
            counts = [size(object%set%accelerometer_time), size(object%set%star_camera_time), &
                      size(object%set%magnetometer_time), 0]
            if (allocated(object%set%orbit_time)) counts(4) = size(object%set%orbit_time)
        class default
            call refuse_handle(SET_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_observations_counts

    !> gracecg_observations_accelerometer
    function c_observations_accelerometer(handle, capacity, time, acceleration, error) result(status) &
        bind(c, name='gracecg_observations_accelerometer')
        integer(c_intptr_t), intent(in), value :: handle
        integer(c_size_t), intent(in), value :: capacity
        real(c_double), intent(inout), optional :: time(*), acceleration(3, *)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        integer :: n

        call start(status, error)
        call check_count(capacity, 'capacity', status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (observations_object_t)
            n = size(object%set%accelerometer_time)
            call check_capacity(n, capacity, status, error)
            if (status == STATUS_OK) then
                if (present(time)) time(:n) = object%set%accelerometer_time
                if (present(acceleration)) acceleration(:, :n) = object%set%acceleration
            end if
        class default
            call refuse_handle(SET_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_observations_accelerometer

    !> gracecg_observations_star_camera
    function c_observations_star_camera(handle, capacity, time, head, quaternion, error) result(status) &
        bind(c, name='gracecg_observations_star_camera')
        integer(c_intptr_t), intent(in), value :: handle
        integer(c_size_t), intent(in), value :: capacity
        real(c_double), intent(inout), optional :: time(*), quaternion(4, *)
        integer(c_int32_t), intent(inout), optional :: head(*)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        integer :: n

        call start(status, error)
        call check_count(capacity, 'capacity', status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (observations_object_t)
            n = size(object%set%star_camera_time)
            call check_capacity(n, capacity, status, error)
            if (status == STATUS_OK) then
                if (present(time)) time(:n) = object%set%star_camera_time
                if (present(head)) head(:n) = object%set%star_camera_head
                if (present(quaternion)) quaternion(:, :n) = object%set%quaternion
            end if
        class default
            call refuse_handle(SET_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_observations_star_camera

    !> gracecg_observations_magnetometer
    function c_observations_magnetometer(handle, capacity, time, flux_density, error) result(status) &
        bind(c, name='gracecg_observations_magnetometer')
        integer(c_intptr_t), intent(in), value :: handle
        integer(c_size_t), intent(in), value :: capacity
        real(c_double), intent(inout), optional :: time(*), flux_density(3, *)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        integer :: n

        call start(status, error)
        call check_count(capacity, 'capacity', status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (observations_object_t)
            n = size(object%set%magnetometer_time)
            call check_capacity(n, capacity, status, error)
            if (status == STATUS_OK) then
                if (present(time)) time(:n) = object%set%magnetometer_time
                if (present(flux_density)) flux_density(:, :n) = object%set%field
            end if
        class default
            call refuse_handle(SET_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_observations_magnetometer

    !> gracecg_observations_orbit
    function c_observations_orbit(handle, capacity, time, position, error) result(status) &
        bind(c, name='gracecg_observations_orbit')
        integer(c_intptr_t), intent(in), value :: handle
        integer(c_size_t), intent(in), value :: capacity
        real(c_double), intent(inout), optional :: time(*), position(3, *)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        integer :: n

        call start(status, error)
        call check_count(capacity, 'capacity', status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (observations_object_t)
            n = 0
            if (allocated(object%set%orbit_time)) n = size(object%set%orbit_time)
            call check_capacity(n, capacity, status, error)
            if (status == STATUS_OK .and. n > 0) then
                if (present(time)) time(:n) = object%set%orbit_time
                if (present(position)) position(:, :n) = object%set%orbit_position
            end if
        class default
            call refuse_handle(SET_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_observations_orbit

    !> gracecg_estimate
    function c_estimate(algorithm, handle, c_solution, warnings, size, error) result(status) &
        bind(c, name='gracecg_estimate')
        character(kind=c_char), intent(in), optional :: algorithm(*)
        integer(c_intptr_t), intent(in), value :: handle
        type(c_solution_t), intent(inout), optional :: c_solution
        character(kind=c_char), intent(inout), optional :: warnings(*)
        integer(c_size_t), intent(in), value :: size
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        type(solution_t) :: solution
        type(error_t), allocatable :: failure
        character(:), allocatable :: name

        call start(status, error)
        call need(present(c_solution), 'solution', status, error)
        call check_count(size, 'size', status, error)
        if (size /= 0) call need(present(warnings), 'warnings', status, error)
        call fortran_text(algorithm, LONGEST_NAME, 'algorithm', name, status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (observations_object_t)
            call estimate_offset(name, object%set, object%options, solution, failure)
            call pass_on(failure, status, error)
        class default
            call refuse_handle(SET_NAME, status, error)
        end select
        call release(int(handle, i8), object)
        if (status /= STATUS_OK) return
        call check_result([solution%offset, [solution%covariance], solution%residual_rms], 'the estimate', &
                          status, error)
        if (status /= STATUS_OK) return
        call give_solution(solution, c_solution)
        call give_warnings(solution%warnings, warnings, size)
        if (.not. solution%converged) &
            call raise(STATUS_NOT_CONVERGED, name//' did not converge in '//integer_text(solution%iterations)// &
                       ' iterations: the offset is not to be relied upon; check guess_quaternion and '// &
                       'guess_angular_velocity of its options', status, error)
    end function c_estimate

    !> gracecg_test_beliefs
    function c_test_beliefs(algorithm, handle, c_beliefs, text, size, error) result(status) &
        bind(c, name='gracecg_test_beliefs')
        character(kind=c_char), intent(in), optional :: algorithm(*)
        integer(c_intptr_t), intent(in), value :: handle
        type(c_beliefs_t), intent(inout), optional :: c_beliefs
        character(kind=c_char), intent(inout), optional :: text(*)
        integer(c_size_t), intent(in), value :: size
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        type(solution_t) :: solution
        type(error_t), allocatable :: failure
        character(:), allocatable :: name, contradicted_text, untested_text

        call start(status, error)
        call need(present(c_beliefs), 'beliefs', status, error)
        call check_count(size, 'size', status, error)
        if (size /= 0) call need(present(text), 'text', status, error)
        call fortran_text(algorithm, LONGEST_NAME, 'algorithm', name, status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (observations_object_t)
            call estimate_offset(name, object%set, object%options, solution, failure)
            if (.not. allocated(failure) .and. .not. allocated(solution%beliefs)) &
                call fail(failure, 'what the setup says could not be tested')
            call pass_on(failure, status, error)
        class default
            call refuse_handle(SET_NAME, status, error)
        end select
        call release(int(handle, i8), object)
        if (status /= STATUS_OK) return
        associate (report => solution%beliefs)
            c_beliefs%undetected = report%undetected()
            c_beliefs%apart = report%apart
            c_beliefs%tested = report%how_many()
            c_beliefs%contradicted = report%how_many(CONTRADICTED)
            c_beliefs%untested = report%how_many(UNTESTED)
            c_beliefs%sign_known = merge(1, 0, report%signs_known)
            call say_contradiction(report, contradicted_text)
            call say_untested(report, untested_text)
        end associate
        call give_lines(contradicted_text//new_line('a')//untested_text//new_line('a'), text, size)
    end function c_test_beliefs

    !> A solution as C has it.
    subroutine give_solution(solution, c_solution)
        type(solution_t), intent(in) :: solution
        type(c_solution_t), intent(inout) :: c_solution

        integer :: i, k

        c_solution%offset = solution%offset
        c_solution%sigma = [(sqrt(solution%covariance(i, i)), i=1, 3)]
        c_solution%covariance = solution%covariance
        c_solution%drift = solution%drift
        c_solution%bias = solution%bias
        c_solution%quaternion = solution%quaternion
        c_solution%angular_velocity = solution%angular_velocity
        c_solution%residual_rms = solution%residual_rms
        c_solution%condition = solution%condition
        c_solution%variance_factor = solution%variance_factor
        c_solution%noise_level = solution%noise_level
        c_solution%noise_corner = solution%noise_corner
        c_solution%star_camera_sigma = solution%star_camera_sigma
        c_solution%edited = solution%edited
        c_solution%parameter_value = 0
        c_solution%parameter_sigma = 0
        c_solution%parameter_name = c_null_char
        c_solution%parameter_count = 0
        if (allocated(solution%parameters)) c_solution%parameter_count = min(size(solution%parameters), &
                MOST_PARAMETERS)
        do i = 1, c_solution%parameter_count
            associate (parameter => solution%parameters(i))
                c_solution%parameter_value(i) = parameter%value
                c_solution%parameter_sigma(i) = parameter%sigma
                do k = 1, len_trim(parameter%name)
                    c_solution%parameter_name(k, i) = parameter%name(k:k)
                end do
            end associate
        end do
        c_solution%iterations = solution%iterations
        c_solution%converged = merge(1, 0, solution%converged)
        c_solution%warning_count = 0
        if (allocated(solution%warnings)) c_solution%warning_count = size(solution%warnings)
    end subroutine give_solution
end module gracecg_interface_c_estimation

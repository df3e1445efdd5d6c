!> How to estimate: what the estimators can be told beside the observations. The defaults are what an
!> algorithm needs no telling, so `&estimation /` is a whole file of options.
!>
!> A file of options has the groups estimation, optimal and sequential. A case file may have them beside its
!> own groups, a setup.nml beside what the operator knows.
module gracecg_estimation_options
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_files_settings, only: settings_t, FULL_RANGE
    use gracecg_observations_knowledge, only: ESTIMATION_GROUPS
    use gracecg_estimation_optimal_options, only: optimal_options_t, describe_optimal
    use gracecg_estimation_sequential_options, only: sequential_options_t, describe_sequential
    implicit none
    private
    public :: estimation_options_t, read_options, options_from_text, options_text, write_options
    public :: OPTIONS_FILE

    character(*), parameter :: OPTIONS_FILE = 'options.nml'     !! In the folder of an observation set
    real(dp), parameter :: SMALLEST_GUESS = 0.5_dp      !! Length of a guessed quaternion, before it is normalised

    !> How to estimate. Nothing here is of the satellite or its instruments: that is operator_knowledge_t.
    type :: estimation_options_t
        logical :: covariance = .true.
        !! Propagate the covariance of the offset and check the fit against noise and torque; no key of a file.
        !! Of the report's estimators this costs as much as the estimate itself. optimal and sequential have
        !! their covariance from the fit and give it in any case: they leave out the checks alone
        logical :: history = .false.    !! Keep every iteration in the solution; no key of a file
        logical :: information = .false.
        !! Of `optimal`: give what a joint estimate of several runs needs; no key of a file
        real(dp) :: guess_quaternion(4) = 0         !! First guess of the attitude at the epoch, inertial to body
        !! (normalised before use); 0: from the star-camera samples
        real(dp) :: guess_angular_velocity(3) = 0   !! At the epoch, body axes, rad/s; 0: from those samples
        real(dp) :: guess_offset(3) = 1e-5_dp       !! d*, body axes, m
        real(dp) :: largest_offset = 1e-2_dp
        !! Of each component, m: gracecg estimate refuses one that is beyond it by five sigmas
        logical :: test_beliefs = .true.
        !! Test what the setup says against the data, if the fit is checked at all
        real(dp) :: wanted_accuracy = 5e-5_dp
        !! Of each component, m: a wrong belief that could move one farther without being seen is said to be untested
        real(dp) :: accelerometer_weight(3) = [10.0_dp, 1.0_dp, 145.0_dp]
        !! Of its axes, in the report's estimators: CSR-TM-00-01 section 6.1
        real(dp) :: star_camera_weight = 1          !! Of every attitude component in ASSEST: ibid.
        real(dp) :: combined_star_camera_weight = 90    !! The same in ASCFEST and ASCREST: ibid.
        type(optimal_options_t) :: optimal = optimal_options_t()              !! Of the estimator `optimal`
        type(sequential_options_t) :: sequential = sequential_options_t()     !! Of the estimator `sequential`
    end type estimation_options_t

contains

    !> Reads a file of options, or those in a file with groups of others. Fails, with file, line and key, for
    !> a key that is not known and a value that is not allowed; a group that is not known is refused in a
    !> file of options alone: in another one, whose groups they are has to see to that.
    subroutine read_options(path, options, error, beside)
        character(*), intent(in) :: path        !! Of the namelist file
        type(estimation_options_t), intent(out) :: options
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: beside !! The file has groups of others, too; absent: options alone

        type(settings_t) :: reader

        call reader%open(path, error)
        if (.not. allocated(error)) call take_options(reader, options, error, beside)
    end subroutine read_options

    !> The same from a text; `name` stands for the file in messages.
    subroutine options_from_text(text, name, options, error, beside)
        character(*), intent(in) :: text, name  !! Content; what stands for the file in messages
        type(estimation_options_t), intent(out) :: options
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: beside !! As of read_options

        type(settings_t) :: reader

        call reader%open_text(text, name, error)
        if (.not. allocated(error)) call take_options(reader, options, error, beside)
    end subroutine options_from_text

    subroutine take_options(reader, options, error, beside)
        type(settings_t), intent(inout) :: reader
        type(estimation_options_t), intent(inout) :: options
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: beside

        call describe_options(reader, options)
        if (present(beside)) then
            call reader%finish(error, only=ESTIMATION_GROUPS)
        else
            call reader%finish(error)
        end if
    end subroutine take_options

    !> The text of a file of options: what `read_options` reads. Fails when a number is not finite.
    subroutine options_text(options, text, error)
        type(estimation_options_t), intent(in) :: options
        character(:), allocatable, intent(out) :: text  !! Lines separated by line feeds
        type(error_t), allocatable, intent(out) :: error

        type(settings_t) :: writer
        type(estimation_options_t) :: copy

        copy = options
        call describe_options(writer, copy)
        call writer%to_text(text, error)
    end subroutine options_text

    !> Writes a file of options. Fails when a number is not finite or the file cannot be written.
    subroutine write_options(path, options, comments, error)
        character(*), intent(in) :: path            !! Of the file; an existing one is replaced
        type(estimation_options_t), intent(in) :: options
        character(*), intent(in) :: comments(:)     !! Its first lines; may be none
        type(error_t), allocatable, intent(out) :: error

        type(settings_t) :: writer
        type(estimation_options_t) :: copy
        integer :: i

        do i = 1, size(comments)
            call writer%comment(trim(comments(i)))
        end do
        copy = options
        call describe_options(writer, copy)
        call writer%save(path, error)
    end subroutine write_options

    !> Every option with its unit and range.
    subroutine describe_options(settings, options)
        type(settings_t), intent(inout) :: settings
        type(estimation_options_t), intent(inout) :: options

        call settings%group('estimation', 'First guesses and weights of the estimators')
        call settings%real_values('guess_quaternion', options%guess_quaternion, -1.0_dp, 1.0_dp, &
                                  'at the epoch, inertial to body, scalar last; 0: from the star-camera samples')
        if (any(abs(options%guess_quaternion) > 0) .and. .not. norm2(options%guess_quaternion) > SMALLEST_GUESS) &
            call settings%reject('guess_quaternion', 'is too far from unit length')
        call settings%real_values('guess_angular_velocity', options%guess_angular_velocity, -1.0_dp, 1.0_dp, &
                                  'rad/s, at the epoch; 0: from the star-camera samples', unit='rad/s')
        call settings%real_values('guess_offset_mm', options%guess_offset, -1000.0_dp, 1000.0_dp, 'mm', &
                                  1e-3_dp, 'mm')
        call settings%real_value('largest_offset_mm', options%largest_offset, 1e-3_dp, 1e6_dp, &
                                 'mm, of a component: estimates beyond it are not plausible and refused', 1e-3_dp, 'mm')
        call settings%logical_value('test_beliefs', options%test_beliefs, 'what the setup says, against the data')
        call settings%real_value('wanted_accuracy_mm', options%wanted_accuracy, 1e-6_dp, 1e3_dp, &
                                 'mm, of a component: beliefs that could move it farther unseen are untested', 1e-3_dp, 'mm')
        call settings%real_values('accelerometer_weight', options%accelerometer_weight, tiny(1.0_dp), &
                                  FULL_RANGE, 'of the axes')
        call settings%real_value('star_camera_weight', options%star_camera_weight, tiny(1.0_dp), FULL_RANGE, &
                                 'of every attitude component, ASSEST')
        call settings%real_value('combined_star_camera_weight', options%combined_star_camera_weight, &
                                 tiny(1.0_dp), FULL_RANGE, 'of every attitude component, ASCFEST and ASCREST')
        call settings%end_group()
        call describe_optimal(settings, options%optimal)
        call describe_sequential(settings, options%sequential)
    end subroutine describe_options
end module gracecg_estimation_options

!> gracecg model star-camera: one noisy frame of a star camera, solved by QUEST and by the q-method.
module gracecg_cli_model_star_camera
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: ARCSECOND
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: integer_text, real_text
    use gracecg_base_quaternion, only: normalised, quaternion_product, rotation_angle_between
    use gracecg_base_random, only: random_stream_t, new_stream
    use gracecg_observations_knowledge, only: HEADS
    use gracecg_simulation_star_catalogue, only: builtin_star_catalogue
    use gracecg_simulation_star_camera, only: star_camera_t, star_frame_t, STAR_SELECTIONS
    use gracecg_simulation_quest, only: quest, q_method
    use gracecg_observations_observation_set, only: SAMPLE_TOLERANCE
    use gracecg_cli_arguments, only: arguments_t
    use gracecg_cli_console, only: console_t
    use gracecg_cli_results, only: results_t, add_format_option, take_format
    use gracecg_files_data_table, only: data_table_t
    implicit none
    private
    public :: declare_star_camera, run_star_camera

contains

    !> Arguments and help of `gracecg model star-camera`.
    subroutine declare_star_camera(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('model star-camera', '', 0, 0, &
                                'One noisy frame of a star camera with the report''s '// &
                                'performance: the attitude by QUEST (inertial J2000 to camera, '// &
                                'scalar last), the number of stars and the angle to the true '// &
                                'attitude.', &
                                'gracecg model star-camera --quaternion -0.7008547 -0.0000031 '// &
                                '0.7133040 0.0000031')
        call arguments%add_option('--quaternion', 'Q1 Q2 Q3 Q4', &
                                  'true attitude, inertial J2000 to body, scalar last', &
                                  required=.true.)
        call arguments%add_option('--head', 'N', '1 looks to +y, 2 to -y of the body', default='1')
        call arguments%add_option('--selection', 'NAME', 'which 20 stars: the first of the catalogue, as in '// &
                                  'the report, or the best', choices=STAR_SELECTIONS, default=trim(STAR_SELECTIONS(1)))
        call arguments%add_option('--seed', 'S', 'of the random numbers', default='1')
        call arguments%add_option('--run', 'K', 'other random numbers of the same seed', default='1')
        call add_format_option(arguments, default='csv')
    end subroutine declare_star_camera

    !> The work of `gracecg model star-camera`.
    subroutine run_star_camera(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(star_camera_t) :: camera
        type(star_frame_t) :: frame
        type(random_stream_t) :: stream
        real(dp) :: attitude(4)
        character(:), allocatable :: selection
        integer(i8) :: seed        !! Of the random numbers
        integer :: head, run

        call arguments%get('--quaternion', attitude, misuse, low=-1.1_dp, high=1.1_dp)
        call arguments%get('--head', head, misuse, low=1, high=HEADS)
        call arguments%get('--selection', selection, misuse)
        call arguments%get('--seed', seed, misuse)
        call arguments%get('--run', run, misuse, low=0)
        call take_format(arguments, console, misuse)
        if (allocated(misuse)) return

        if (abs(norm2(attitude) - 1) > SAMPLE_TOLERANCE) then
            call fail(error, 'option --quaternion: not a unit quaternion: its length is '// &
                      real_text(norm2(attitude))//'; allowed is 1 within '// &
                      real_text(SAMPLE_TOLERANCE))
            return
        end if
        attitude = normalised(attitude)
        camera%selection = selection
        call camera%see(builtin_star_catalogue(), attitude, head, frame, error)
        if (allocated(error)) return
        call console%line('# stars in the field = '// &
                          integer_text(camera%stars_in_field(builtin_star_catalogue(), attitude, head))// &
                          ', mean of all attitudes '// &
                          real_text(anint(10*camera%mean_stars_in_field(builtin_star_catalogue()))/10))
        stream = new_stream(seed, 0, 0, run, head)
        call solve(frame, quaternion_product(camera%mounting(head), attitude), stream, console, &
                   error)
    end subroutine run_star_camera

    !> Draws the frame's directions and shows both solutions.
    subroutine solve(frame, true_attitude, stream, console, error)
        type(star_frame_t), intent(in) :: frame
        real(dp), intent(in) :: true_attitude(4)    !! Inertial to camera
        type(random_stream_t), intent(inout) :: stream
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(data_table_t) :: table
        type(results_t) :: results
        real(dp) :: observed(3, size(frame%reference, 2)), deviation(size(frame%reference, 2))
        real(dp) :: q(4), q_reference(4), covariance(3, 3), loss, sigma(3)
        integer :: i

        deviation = frame%noise*frame%relative_deviation
        call frame%measure(stream, observed)
        call q_method(observed, frame%reference, deviation, q_reference, covariance, loss, error)
        if (allocated(error)) return
        call quest(observed, frame%reference, deviation, q, covariance, loss, error)
        if (allocated(error)) return
        ! (3-21) is of half the angles
        sigma = [(2*sqrt(covariance(i, i))/ARCSECOND, i=1, 3)]
        call table%columns_of('q1,q2,q3,q4,stars,angle_error_arcsec,quest_and_q_method_arcsec,sigma_x_arcsec,'// &
                              'sigma_y_arcsec,sigma_boresight_arcsec')
        call table%add(q)
        call table%add(size(observed, 2))
        call table%add(rotation_angle_between(q, true_attitude)/ARCSECOND)
        call table%add(rotation_angle_between(q, q_reference)/ARCSECOND)
        call table%add(sigma)
        call results%open('model star-camera')
        call results%publish(table, console, error)
    end subroutine solve
end module gracecg_cli_model_star_camera
